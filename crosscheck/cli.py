"""The command line: list, run, simulate, report, show, engines, prove, calibrate."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path
from typing import Annotated, NoReturn, Optional

import typer

from crosscheck.engines.workers.ending import TIME_LIMIT, interruptible

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Tells whether a particle-simulation code is right, how fast it is, and where it breaks.",
)


def _print_version(asked: bool) -> None:
    if asked:
        from crosscheck import __version__

        print(f"crosscheck {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version, and exit.")
    ] = False,
) -> None:
    """Options of the program itself. version: print the version."""


Engines = Annotated[
    Optional[list[str]],  # noqa: UP045 - typer reads it
    typer.Option(
        "--engine",
        "-e",
        help="Engine to judge: a name, or path.py:Class. Repeatable. Default: all installed.",
    ),
]


def _positive(seconds: float) -> float:
    if not seconds > 0:
        raise typer.BadParameter(f"{seconds:g}: give a number of seconds, more than 0 (inf: no limit)")
    return seconds


TimeLimit = Annotated[
    float,
    typer.Option(
        "--time-limit",
        metavar="SECONDS",
        callback=_positive,
        help="How long one call of an engine may take, compilation included, before it counts as hung and is ended.",
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
    time_limit: TimeLimit = TIME_LIMIT,
    require: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--require", help="Engine that must be there, and judged if the run has it. Repeatable."),
    ] = None,
    allow_inconclusive: Annotated[
        bool, typer.Option("--allow-inconclusive", help="Inconclusive verdicts count as passed.")
    ] = False,
) -> None:
    """Simulate, compare, judge, and write the record and the report.

    Exit status: 0 all pass, 1 a check failed or ended in error, 2 bad usage or input, 3 a verdict is inconclusive, 4
    nothing was judged (at all, or of an engine named by --engine or --require), 130 after Ctrl-C, 143 after
    SIGTERM.
    """
    from crosscheck import commands

    raise typer.Exit(
        interruptible(
            lambda: commands.run(
                patterns or [],
                tier,
                engine or [],
                seed,
                jobs,
                out,
                resume,
                junit,
                require or [],
                allow_inconclusive,
                time_limit,
            )
        )
    )


@app.command()
def prove(
    checks: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of check names.")] = None,  # noqa: UP045
    jobs: Annotated[Optional[int], typer.Option(min=1, help="Faults at a time. Default: one per core.")] = None,  # noqa: UP045
    seed: Annotated[int, typer.Option(min=0, help="Seed of the suite; with --mutate, that of the draw.")] = 0,
    time_limit: TimeLimit = TIME_LIMIT,
    mutants: Annotated[
        Optional[int],  # noqa: UP045
        typer.Option(
            "--mutate", min=1, metavar="N", help="Draw N random mutations of the sources in place of the faults."
        ),
    ] = None,
    tier: Annotated[str, typer.Option(help="With --mutate: the cases that judge, quick or full.")] = "quick",
    modules: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--module", help="With --mutate: shell pattern of files or folders to mutate. Repeatable."),
    ] = None,
    population: Annotated[
        str, typer.Option(help="With --mutate: refimpl, adapters (of the engines) or performance (cost alone).")
    ] = "refimpl",
    out: Annotated[
        Path, typer.Option("--out", "-o", help="With --mutate: directory for the mutants and the score.")
    ] = Path("crosscheck-mutants"),
    resume: Annotated[Path | None, typer.Option(help="With --mutate: complete the sample in this directory.")] = None,
) -> None:
    """Run checks with their planted faults in a copy of refimpl: each must turn its check red.

    With --mutate: random mutations, each judged by the cases of these checks that execute it; the share that is caught.

    Exit status: 0 if all faults are seen, or the sample is complete, 1 if not, 2 bad usage or input.
    """
    from crosscheck import commands

    if mutants is None:
        raise typer.Exit(interruptible(lambda: commands.prove(checks or [], jobs, seed, time_limit)))
    sample = commands.Sample(mutants, seed, tier, tuple(checks or ()), tuple(modules or ()), population)
    raise typer.Exit(interruptible(lambda: commands.mutate(sample, jobs, out, resume)))


@app.command()
def calibrate(
    checks: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of check names.")] = None,  # noqa: UP045
    seeds: Annotated[int, typer.Option(help="Number of seeds of the suite, from 0.")] = 100,
    tier: Annotated[str, typer.Option(help="quick, or full, which contains the quick one.")] = "quick",
    engine: Engines = None,
    jobs: Annotated[Optional[int], typer.Option(min=1, help="Runs at a time. Default: one per core.")] = None,  # noqa: UP045
    out: Annotated[Path, typer.Option("--out", "-o", help="File for the table (Markdown).")] = Path("calibration.md"),
    time_limit: TimeLimit = TIME_LIMIT,
) -> None:
    """Judge statistical cases with many seeds: p-values must be uniform, and deviations seen that should be.

    Exit status: 0 if so, 1 if the p-values of a quantity are not uniform or a case ended in error, 2 bad usage or
    input.
    """
    from crosscheck import commands

    raise typer.Exit(
        interruptible(lambda: commands.calibrate(checks or [], tier, engine or [], seeds, jobs, out, time_limit))
    )


@app.command()
def simulate(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML), or the name of a shipped scene.")],
    engine: Engines = None,
    out: Out = Path("crosscheck-out"),
    time_limit: TimeLimit = TIME_LIMIT,
    restart: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="Go on from this file, restart-<engine>.npz of an earlier run of the scene."),
    ] = None,
    method: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(
            metavar="[ENGINE:]KEY=VALUE,...",
            help="Method of one engine, or of all: entries of the scene's table \\[method], as "
            "rebound:scheme=collisions_direct,dt=0.001. Repeatable; twice for one engine: two runs of it.",
        ),
    ] = None,
) -> None:
    """Run a scene; print a summary, and write all that it records, and a picture, of several engines side by side.

    Exit status: 0 the runs went to their end, 1 one diverged or stopped, 2 bad usage or input.
    """
    from crosscheck import commands

    engines, methods = engine or ["refimpl"], method or []
    raise typer.Exit(interruptible(lambda: commands.simulate(scene, engines, out, time_limit, restart, methods)))


@app.command()
def report(directory: Annotated[Path, typer.Argument(help="Directory of a run.")]) -> None:
    """Write the HTML report of a run again, from its record."""
    from crosscheck import commands

    commands.report(directory)


def _open_standard_streams() -> None:
    """Opens those of stdin, stdout and stderr that are closed on /dev/null: pipes would get their numbers."""
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free, which is this one
            os.set_inheritable(opened, True)
            setattr(sys, name, open(opened, mode, closefd=False, encoding="utf-8"))  # noqa: SIM115


def main() -> None:
    """Entry point, the one place where exceptions become messages and an exit status.

    UsageError, and an OSError of any file: a line, status 2. EngineError: status 1. Too little memory: 2. Output into
    a pipe that was closed, as by `head`, ends quietly, with status 1.
    """
    from crosscheck.errors import EngineError, UsageError

    _open_standard_streams()
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
