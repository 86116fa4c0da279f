"""The command line: list, run, diff, baseline, simulate, compare, repeat, inspect, report, export, show, prove ..."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path
from typing import Annotated, NoReturn, Optional

import typer

from crosscheck.engines.workers.ending import TIME_LIMIT, interruptible
from crosscheck.trajectories.writers import names as format_names

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


def _share(number: Optional[float]) -> Optional[float]:  # noqa: UP045
    if number is not None and not 0 < number < 1:
        raise typer.BadParameter(f"{number:g}: give a number between 0 and 1")
    return number


TimeLimit = Annotated[
    float,
    typer.Option(
        "--time-limit",
        metavar="SECONDS",
        callback=_positive,
        help="How long one call of an engine may take, compilation included, before it counts as hung and is ended.",
    ),
]
Budget = Annotated[
    Optional[float],  # noqa: UP045
    typer.Option(
        metavar="SECONDS",
        callback=lambda seconds: None if seconds is None else _positive(seconds),
        help="For slow codes: measure their speed, run what ends within this time, most checks first, and say what was "
        "left out.",
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Directory for the record and the report.")]
Summary = Annotated[
    Optional[Path],  # noqa: UP045
    typer.Option(help="Also write a summary in Markdown to this file, as it is added to $GITHUB_STEP_SUMMARY."),
]


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
    tier: Annotated[
        str, typer.Option(help="quick, or full, which contains the quick one; small: what stands for larger cases.")
    ] = "quick",
    engine: Engines = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the suite; every case derives its own from it.")] = 0,
    jobs: Annotated[Optional[int], typer.Option(min=1, help="Cases at a time. Default: one per core.")] = None,  # noqa: UP045
    out: Out = Path("crosscheck-out"),
    resume: Annotated[Optional[Path], typer.Option(help="Complete the interrupted run in this directory.")] = None,  # noqa: UP045
    junit: Annotated[Optional[Path], typer.Option(help="Also write JUnit XML to this file.")] = None,  # noqa: UP045
    time_limit: TimeLimit = TIME_LIMIT,
    budget: Budget = None,
    require: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--require", help="Engine that must be there, and judged if the run has it. Repeatable."),
    ] = None,
    allow_inconclusive: Annotated[
        bool, typer.Option("--allow-inconclusive", help="Inconclusive verdicts count as passed.")
    ] = False,
    baseline: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="File of known results: failures that it knows do not turn the run red, what is worse does."),
    ] = None,
    summary: Summary = None,
) -> None:
    """Simulate, compare, judge, and write the record and the report.

    Exit status: 0 all pass, 1 a check failed, 2 bad usage or input, 3 a verdict is inconclusive, 4 a case could not
    run, or nothing was judged (at all, or of an engine named by --engine or --require), 130 after Ctrl-C, 143 after
    SIGTERM. With --baseline it follows from what differs from the baseline, as of `diff`.
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
                baseline,
                summary,
                budget,
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

    Exit status: 0 if all faults are seen, or the sample is complete, 1 if one is not seen, 2 bad usage or input, 4 if
    a case could not run.
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

    Exit status: 0 if so, 1 if the p-values of a quantity are not uniform, 2 bad usage or input, 4 if a case could not
    run, or nothing is judged statistically.
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
    formats: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(
            "--format",
            "-f",
            metavar="NAME",
            help=f"Format of the trajectories: {', '.join(format_names())}. Repeatable. Default: extxyz.",
        ),
    ] = None,
    method: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(
            metavar="[ENGINE:]KEY=VALUE,...",
            help="Method of one engine, or of all: entries of the scene's table \\[method], as "
            "rebound:scheme=collisions_direct,dt=0.001. Repeatable; twice for one engine: two runs of it.",
        ),
    ] = None,
    judge: Annotated[
        bool, typer.Option("--judge", help="Judge all that holds for any scene; record and report as of run.")
    ] = False,
    tolerance: Annotated[
        Optional[float],  # noqa: UP045
        typer.Option(
            metavar="SHARE",
            callback=_share,
            help="With --judge: dt is halved until positions and energy change by less, relative.  [default: 0.001]",
        ),
    ] = None,
    allow_inconclusive: Annotated[
        bool, typer.Option("--allow-inconclusive", help="With --judge: inconclusive verdicts count as passed.")
    ] = False,
) -> None:
    """Run a scene; print a summary, and write all that it records, and a picture, of several engines side by side.

    Exit status: 0 the runs went to their end, 1 one diverged or stopped, 2 bad usage or input, 4 an engine failed; with
    --judge also 1 a law is broken, 3 a verdict is inconclusive, 4 nothing was judged.
    """
    from crosscheck import commands

    engines, written, methods = engine or ["refimpl"], tuple(formats or ()), tuple(method or ())
    if judge:
        demand = commands.Demand(tolerance or 1e-3, allow_inconclusive)
        raise typer.Exit(
            interruptible(lambda: commands.judge(scene, engines, out, time_limit, restart, written, methods, demand))
        )
    if tolerance is not None or allow_inconclusive:
        option = "--tolerance" if tolerance is not None else "--allow-inconclusive"
        raise typer.BadParameter(f"{option} is for verdicts: add --judge, or remove it")
    raise typer.Exit(
        interruptible(lambda: commands.simulate(scene, engines, out, time_limit, restart, written, methods))
    )


Mode = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option(
        "--mode",
        help="Standard by which results are the same: exact (bits), tolerance (rounding of the files, or --tolerance), "
        "chaos (rounding and chaos explain the difference), or statistics. Default: chaos; of tables in time, "
        "statistics; of repeat, exact.",
    ),
]
Arithmetic = Annotated[str, typer.Option("--arithmetic", help="Of the runs: double, or single (also mixed).")]


@app.command()
def compare(
    results: Annotated[
        list[Path],
        typer.Argument(
            help="Two or more files of results, or directories with one each (LAMMPS dump, extxyz, XTC ...)."
        ),
    ],
    mode: Mode = None,
    tolerance: Annotated[
        Optional[float],  # noqa: UP045
        typer.Option(
            metavar="DISTANCE", help="With --mode tolerance: distance of a particle from itself that counts as none."
        ),
    ] = None,
    arithmetic: Arithmetic = "double",
    topology: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="File with ids, types and masses, for formats that hold coordinates alone (XTC, DCD ...)."),
    ] = None,
    scene: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="Scene whose rate of chaos is measured by a disturbed twin, where the data do not show it."),
    ] = None,
    engine: Annotated[
        str, typer.Option("--engine", "-e", help="With --scene: the engine that runs the twin.")
    ] = "refimpl",
    out: Annotated[Path, typer.Option("--out", "-o", help="Directory for the page and the JSON.")] = Path(
        "crosscheck-compare"
    ),
    time_limit: TimeLimit = TIME_LIMIT,
) -> None:
    """Tell whether results are the same: to the last bit, within rounding, up to chaos, or in their statistics.

    Exit status: 0 the same by the standard of --mode, 1 different, 2 bad usage or input, 3 it cannot be told.
    """
    from crosscheck import commands

    asked = commands.Standard(mode, tolerance, arithmetic, topology, scene, engine, time_limit)
    raise typer.Exit(interruptible(lambda: commands.compare(results, asked, out)))


@app.command()
def repeat(
    scene: Annotated[Path, typer.Argument(help="Scene file (TOML), or the name of a shipped scene.")],
    engine: Annotated[str, typer.Option("--engine", "-e", help="Engine: a name, or path.py:Class.")] = "refimpl",
    times: Annotated[int, typer.Option(min=1, help="Runs for each number of threads.")] = 20,
    threads: Annotated[
        Optional[list[int]],  # noqa: UP045
        typer.Option(
            min=1, help="Threads that the engine's libraries may use (OMP_NUM_THREADS). Repeatable. Default: 1."
        ),
    ] = None,
    mode: Mode = None,
    arithmetic: Arithmetic = "double",
    out: Annotated[Path, typer.Option("--out", "-o", help="Directory for the runs and the comparison.")] = Path(
        "crosscheck-repeat"
    ),
    time_limit: TimeLimit = TIME_LIMIT,
) -> None:
    """Run a scene several times, each in a new process: is the engine deterministic, and which run left the others
    when?

    Exit status: 0 the same by the standard of --mode, 1 different, 2 bad usage or input, 3 it cannot be told.
    """
    from crosscheck import commands

    asked = commands.Standard(mode, None, arithmetic, None, None, engine, time_limit)
    raise typer.Exit(interruptible(lambda: commands.repeat(scene, engine, times, threads or [1], asked, out)))


@app.command()
def diff(
    old: Annotated[Path, typer.Argument(help="Directory of a run, its record, or a baseline.")],
    new: Annotated[Path, typer.Argument(help="The same of what is compared with it.")],
    beside: Annotated[
        str, typer.Option(metavar="ENGINE", help="Engine of both runs that the times of the others are compared with.")
    ] = "refimpl",
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document instead of text.")] = False,
    summary: Summary = None,
) -> None:
    """Say what differs between two runs: new failures, changes beyond uncertainty, what is slower or no longer tested.

    Exit status: 0 nothing worse, 1 a new failure, a change beyond uncertainty, or more operations, 2 bad usage or
    input, 3 what was decided is inconclusive now, 4 no longer tested, could not run, or nothing to compare.
    """
    from crosscheck import commands

    raise typer.Exit(commands.diff(old, new, beside, as_json, summary))


baselines = typer.Typer(no_args_is_help=True, help="Edit the file of the results that are known, docs/regression.md.")
app.add_typer(baselines, name="baseline")


@baselines.command()
def accept(
    checks: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of check names. Default: all.")] = None,  # noqa: UP045
    engine: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--engine", "-e", help="Engine whose results are accepted. Repeatable. Default: all of the run."),
    ] = None,
    baseline: Annotated[Path, typer.Option(help="The file, made if it is not there.")] = Path(
        "crosscheck-baseline.txt"
    ),
    run: Annotated[Path, typer.Option("--from", help="Directory of the run whose results are accepted.")] = Path(
        "crosscheck-out"
    ),
) -> None:
    """Write results of a run into the baseline, whatever they are; other lines stay as they are.

    Exit status: 0, or 2 on bad usage or input.
    """
    from crosscheck import commands

    raise typer.Exit(commands.accept_baseline(checks or [], engine or [], baseline, run))


@app.command()
def inspect(
    trajectory: Annotated[Path, typer.Argument(help="File of a trajectory, in any format that is read.")],
    scene: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="Scene that was run: masses, sizes, box, potential, and what it conserves."),
    ] = None,
    topology: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(help="File with types and masses, for formats that hold coordinates alone."),
    ] = None,
    ensemble: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(help="What the run is taken for: equilibrium, nvt, nve or none. Default: as the scene says."),
    ] = None,
    temperature: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(help="k_B T that it should have, in mass velocity^2 of the file; or in kelvin, as 300K."),
    ] = None,
    mass: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(metavar="TYPE=MASS", help="Mass of a type, where the file states none. Repeatable."),
    ] = None,
    hard: Annotated[bool, typer.Option("--hard", help="Particles with diameters must not overlap.")] = False,
    homogeneous: Annotated[bool, typer.Option("--homogeneous", help="The radial distribution must go to 1.")] = False,
    constraints: Annotated[int, typer.Option(min=0, help="Number of degrees of freedom that are constrained.")] = 0,
    skip: Annotated[
        float, typer.Option(metavar="SHARE", help="Share of the frames at the start that is left out of statistics.")
    ] = 0.2,
    arithmetic: Annotated[str, typer.Option(help="Arithmetic of the run, double or single.")] = "double",
    results: Annotated[Optional[Path], typer.Option("--json", help="Also write all of it as JSON.")] = None,  # noqa: UP045
    page: Annotated[Optional[Path], typer.Option(help="Also write a page with figures (HTML).")] = None,  # noqa: UP045
    allow_inconclusive: Annotated[
        bool, typer.Option("--allow-inconclusive", help="Inconclusive verdicts count as passed.")
    ] = False,
) -> None:
    """Inspect one trajectory alone: frames, motion, conservation, velocities, structure, each with a verdict.

    Exit status: 0 nothing is wrong, 1 a property is red, 2 bad usage or input, 3 a verdict is inconclusive, 4 nothing
    but the file itself could be judged.
    """
    from crosscheck import commands

    said = commands.Said(scene, ensemble, temperature, mass or [], hard, homogeneous, constraints, skip, arithmetic)
    raise typer.Exit(
        interruptible(lambda: commands.inspect(trajectory, topology, said, results, page, allow_inconclusive))
    )


@app.command()
def report(directory: Annotated[Path, typer.Argument(help="Directory of a run.")]) -> None:
    """Write the HTML report of a run again, from its record."""
    from crosscheck import commands

    commands.report(directory)


@app.command()
def export(
    record: Annotated[Path, typer.Argument(help="Directory of a run, or its record.")],
    file: Annotated[Path, typer.Argument(help="File to write: .csv, or .parquet, which needs pyarrow.")],
) -> None:
    """Write a record as a flat table for analysis, a row for each judgement."""
    from crosscheck import commands

    commands.export(record, file)


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

    UsageError, and an OSError of any file: a line, status 2. EngineError: status 4. Too little memory: 2. Output into
    a pipe that was closed, as by `head`, ends quietly, with status 141, as of a program that SIGPIPE ends.
    """
    from crosscheck.errors import EngineError, UsageError

    _open_standard_streams()
    # this process multiplies small matrices alone, for which threads wait longer than they compute
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if isinstance(sys.stdout, io.TextIOWrapper):  # names of files may hold bytes that the terminal's encoding has not
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except BrokenPipeError:
        _end_quietly()
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # typer takes it for status 1, which is of wrong physics
            _end_quietly()
        raise
    except UsageError as error:
        _complain(str(error), "USAGE")
    except EngineError as error:
        _complain(str(error), "UNJUDGED")
    except OSError as error:
        from crosscheck.files import shown_path

        if error.filename is None:  # whatever is written to a file of the user names it: see `files.naming`
            _drop_output()
            _complain(f"output: {error.strerror or error}", "USAGE")
        _complain(f"{shown_path(os.fsdecode(error.filename))}: {error.strerror or error}", "USAGE")
    except MemoryError:
        _complain("not enough memory: take fewer particles, samples or cells", "USAGE")


def _status(name: str) -> int:
    """The number of an exit status. name: in the table of them, which is imported once a command has ended badly."""
    from crosscheck.status import Status

    return int(Status[name])


def _complain(message: str, status: str) -> NoReturn:
    """Prints a message, and ends with a status by its name."""
    from crosscheck.text import printable

    print(f"crosscheck: {printable(message, keep=chr(10))}", file=sys.stderr)
    sys.exit(_status(status))


def _end_quietly() -> NoReturn:
    """Ends without a word, where nobody reads the output any more."""
    _drop_output()
    sys.exit(_status("PIPE_CLOSED"))


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
