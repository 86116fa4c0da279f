"""What is written for the machine: compiled code for `refimpl.lattice.bitplanes` only.

The readable form stands beside this folder; tests compare all three bit for bit.

| kernel | readable form |
|---|---|
| `planes` | `plain.PlainGas`, numpy; `lookup.LookupGas`, site by site |
| `words` | `logic.program`: the operations that it lays out; words of 512 bits as a type |
"""
