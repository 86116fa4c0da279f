"""Checks of time-step dynamics: integrators, springs, gravity, Lennard-Jones."""
