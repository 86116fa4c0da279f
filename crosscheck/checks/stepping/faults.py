"""Where the faults of this group's checks are planted."""

from __future__ import annotations

from crosscheck.faults import Fault


def scheme_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    """A fault `name` in the schemes: the text `old` becomes `new`; breaks: what that does, in words."""
    return Fault(name, "stepping/schemes.py", old, new, breaks)


def gravity_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    """A fault `name` in the forces of gravity: the text `old` becomes `new`; breaks: what that does, in words."""
    return Fault(name, "stepping/forces/gravity.py", old, new, breaks)


def pair_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    """A fault `name` in the kernel of Lennard-Jones pairs: the text `old` becomes `new`; breaks: what that does."""
    return Fault(name, "stepping/kernels/lennard_jones.py", old, new, breaks)


#: A thermostat that cools although none is asked for.
LOSS = scheme_fault(
    "velocities-lost",
    "        return r, add_to(v_half, 0.5 * dt, a), (a,)\n",
    "        return r, (1 - 0.03 * dt) * add_to(v_half, 0.5 * dt, a), (a,)\n",
    "velocities decay at the rate 0.03: the energy falls by half within a run of 16",
)
#: The first lists are used for all of a run.
STALE_LISTS = Fault(
    "lists-never-rebuilt",
    "stepping/kernels/neighbours.py",
    "        if still_close:",
    "        if still_close or not still_close:",
    "pairs that were not within reach at the start never interact",
)
