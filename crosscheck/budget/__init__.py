"""A run within a number of seconds: how much there is to do, how fast an engine is, and what is chosen.

`loads` knows how many steps, events and sites the cases consist of, counted once (`counting`); `speeds` measures what
an engine takes for one; `plan` chooses cases, most of the checks first. See docs/slow-codes.md.
"""
