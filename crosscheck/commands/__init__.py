"""The commands of the command line: what each does and prints. `cli` has their options."""

from crosscheck.commands.calibrating import calibrate
from crosscheck.commands.listing import engines, list_checks, report, show
from crosscheck.commands.proving import prove
from crosscheck.commands.running import run
from crosscheck.commands.simulating import simulate

__all__ = ["calibrate", "engines", "list_checks", "prove", "report", "run", "show", "simulate"]
