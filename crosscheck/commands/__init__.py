"""The commands of the command line: what each does and prints. `cli` has their options."""

from crosscheck.commands.calibrating import calibrate
from crosscheck.commands.comparing import Standard, compare, repeat
from crosscheck.commands.exporting import export
from crosscheck.commands.inspecting import Said, inspect
from crosscheck.commands.listing import engines, list_checks, report, show
from crosscheck.commands.mutating import Sample, mutate
from crosscheck.commands.proving import prove
from crosscheck.commands.regressing import accept_baseline, diff
from crosscheck.commands.running import run
from crosscheck.commands.simulating import Demand, judge, simulate

__all__ = [
    "Demand", "Said", "Sample", "Standard", "accept_baseline", "calibrate", "compare", "diff", "engines", "export",
    "inspect", "judge", "list_checks", "mutate", "prove", "repeat", "report", "run", "show", "simulate",
]  # fmt: skip
