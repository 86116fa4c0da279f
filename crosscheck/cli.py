"""The command line: list, run, simulate, report, show, engines, prove."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path
from typing import Annotated, NoReturn, Optional

import typer

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Tells whether a particle-simulation code is right, how fast it is, and where it breaks.",
)

Engines = Annotated[
    Optional[list[str]],  # noqa: UP045 - typer reads it
    typer.Option(
        "--engine",
        "-e",
        help="Engine to judge: a name, or path.py:Class. Repeatable. Default: all installed.",
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Directory for the record and the report.")]


@app.command("list")
def list_checks(
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document instead of a table.")] = False,
) -> None:
    """List the checks, their tier, engines and variants."""
    from crosscheck import commands

    commands.list_checks(as_json)


@app.command()
def show(check: Annotated[str, typer.Argument(help="Name of a check.")]) -> None:
    """Print equation, criterion, needs, variants and planted faults of a check."""
    from crosscheck import commands

    commands.show(check)


@app.command()
def engines() -> None:
    """Print which engines are found, and which are missing and why."""
    from crosscheck import commands

    commands.engines()


@app.command()
def run(
    patterns: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of check names.")] = None,  # noqa: UP045
    tier: Annotated[str, typer.Option(help="quick, or full, which contains the quick one.")] = "quick",
    engine: Engines = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the suite; every case derives its own from it.")] = 0,
    jobs: Annotated[Optional[int], typer.Option(min=1, help="Cases at a time. Default: one per core.")] = None,  # noqa: UP045
    out: Out = Path("crosscheck-out"),
    resume: Annotated[Optional[Path], typer.Option(help="Complete the interrupted run in this directory.")] = None,  # noqa: UP045
    junit: Annotated[Optional[Path], typer.Option(help="Also write JUnit XML to this file.")] = None,  # noqa: UP045
) -> None:
    """Simulate, compare, judge, and write the record and the report.

    Exit status: 0 all pass, 1 a check failed or ended in error, 2 bad usage or input.
    """
    from crosscheck import commands

    raise typer.Exit(commands.run(patterns or [], tier, engine or [], seed, jobs, out, resume, junit))


@app.command()
def prove(
    checks: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of check names.")] = None,  # noqa: UP045
    jobs: Annotated[Optional[int], typer.Option(min=1, help="Faults at a time. Default: one per core.")] = None,  # noqa: UP045
    seed: Annotated[int, typer.Option(min=0, help="Seed of the suite.")] = 0,
) -> None:
    """Run checks with their planted faults in a copy of refimpl: each must turn its check red.

    Exit status: 0 if all do, 1 if not, 2 bad usage or input.
    """
    from crosscheck import commands

    raise typer.Exit(commands.prove(checks or [], jobs, seed))


@app.command()
def simulate(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML), or the name of a shipped scene.")],
    engine: Engines = None,
    out: Out = Path("crosscheck-out"),
) -> None:
    """Run a scene; write observables, trajectory and a picture, of several engines side by side."""
    from crosscheck import commands

    commands.simulate(scene, engine or ["refimpl"], out)


@app.command()
def report(directory: Annotated[Path, typer.Argument(help="Directory of a run.")]) -> None:
    """Write the HTML report of a run again, from its record."""
    from crosscheck import commands

    commands.report(directory)


def main() -> None:
    """Entry point, the one place where exceptions become messages and an exit status.

    UsageError, and an OSError of any file: a line, status 2. EngineError: status 1. Too little memory: 2. Output into
    a pipe that was closed, as by `head`, ends quietly, with status 1.
    """
    from crosscheck.errors import EngineError, UsageError

    if isinstance(sys.stdout, io.TextIOWrapper):  # names of files may hold bytes that the terminal's encoding has not
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except BrokenPipeError:
        _drop_output()
        sys.exit(1)
    except UsageError as error:
        _complain(str(error), 2)
    except EngineError as error:
        _complain(str(error), 1)
    except OSError as error:
        from crosscheck.files import shown_path

        if error.filename is None:  # whatever is written to a file of the user names it: see `files.naming`
            _drop_output()
            _complain(f"output: {error.strerror or error}", 2)
        _complain(f"{shown_path(os.fsdecode(error.filename))}: {error.strerror or error}", 2)
    except MemoryError:
        _complain("not enough memory: take fewer particles, samples or cells", 2)


def _complain(message: str, status: int) -> NoReturn:
    from crosscheck.text import printable

    print(f"crosscheck: {printable(message, keep=chr(10))}", file=sys.stderr)
    sys.exit(status)


def _drop_output() -> None:
    """Sends what is left of the output nowhere, where it cannot be written: it would fail again at the end."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
    except (OSError, ValueError, AttributeError):
        pass  # there is no output


if __name__ == "__main__":
    main()
