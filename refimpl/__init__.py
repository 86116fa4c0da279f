"""Reference implementations of documented particle-simulation algorithms: numpy and numba, no input or output.

`refimpl.stepping`: time-step-driven dynamics.
"""
