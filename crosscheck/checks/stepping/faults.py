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
