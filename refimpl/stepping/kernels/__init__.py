"""What is written for the machine: compiled code for `refimpl.stepping.forces` only.

The readable form stands beside this folder, in the module of the force, or with the tests; these compare the two.

| kernel | readable form |
|---|---|
| `lennard_jones`, `neighbours` | `tests/support/plain_lennard_jones.py`: all pairs, all images |
| `gravity` | `forces.gravity.plain_acceleration` |
| `contacts` | the equations of `forces.grains` |
| `sums` | `np.sum`, to round-off |
| `simd`, `compiled` | none: vectors of eight doubles as a type; how kernels are compiled |
"""
