"""Reference implementations of documented particle-simulation algorithms: numpy and numba, no input or output.

`refimpl.stepping`: time-step-driven dynamics. `refimpl.events`: event-driven dynamics. `refimpl.lattice`: lattice
gases. `refimpl.random_bits`: random bits as a hash. In each part the readable form stands first, and `kernels/` holds
the compiled code that is written for the machine.
"""
