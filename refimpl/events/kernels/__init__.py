"""What is written for the machine: compiled code for `refimpl.events.simulation` only.

The readable form stands beside this folder: `naive` is the algorithm, and `prediction` and `rules` are its closed
forms, which the kernels call too. Tests compare the events of both, one by one.

| kernel | readable form |
|---|---|
| `loop`, `schedule` | `naive.Naive.run`: predict all events, take the earliest |
| `measure` | sums over the events of a trace, in its tests |
| `neighbours` | `state.bonds_of`: all pairs |
| `memory`, `compiled` | none: hints to the processor; how kernels are compiled |
"""
