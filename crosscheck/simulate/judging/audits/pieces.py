"""Where short runs for an audit begin: where a run began, and where one ended."""

from __future__ import annotations

import math
from collections.abc import Iterable

from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene, explicit
from crosscheck.simulate.judging.recording import with_observables
from crosscheck.simulate.judging.trial import Extra, Trial


def from_start_and_end(trial: Trial) -> list[tuple[str, Scene]]:
    """The scene with the initial state that it has, and with the state at the end of the run; in words, where.

    The second one is left out where it is no state to begin with. trial: the run.
    """
    found = [("from the start", trial.scene)]
    end = None if trial.broken else from_end_of(trial, trial.run, trial.end)
    return found if end is None else [*found, ("from the end", end)]


def step_by_step(trial: Trial, steps: int, names: Iterable[str], *, forces: bool = False) -> list[tuple[str, Extra]]:
    """Runs of so many steps that record all of them, from the start and from the end; in words, where each begins.

    trial: the run. steps: number of them. names: of what is recorded, as far as the engine measures it. forces: record
    forces too, if the engine can.
    """
    dt, found = trial.method.step, []
    for where, scene in from_start_and_end(trial):
        piece = with_output(scene, trial.method, steps * dt, interval=dt)
        with_forces = piece.model_copy(update={"output": piece.output.model_copy(update={"forces": True})})
        if forces and trial.able(with_forces):
            piece = with_forces
        output = with_observables(trial.planned.engine, piece, trial.method, piece.output, names)
        piece = piece.model_copy(update={"output": output})
        found.append((where, Extra(f"the audit of steps {where}", piece, trial.method, trial.seconds(steps * dt))))
    return found


def from_end_of(trial: Trial, run: Run, time: float) -> Scene | None:
    """The scene with the state at the end of a run of it; None if that is no state to begin with.

    So it is where hard spheres overlap by more than rounding. Walls that oscillate go on from where they were, if the
    engine understands their phase. trial: the run that is judged. run: it, or another one of its scene. time: its end.
    """
    last = explicit(run["final_positions"], run["final_velocities"], run.get("final_angular_velocities"))
    scene = trial.scene.model_copy(update={"initial": last, "seed": trial.seed})
    moved = _walls_moved_on(scene, time)
    scene = moved if trial.able(moved) else scene
    try:
        scene.own_start()
    except UsageError:
        return None
    return scene


def _walls_moved_on(scene: Scene, time: float) -> Scene:
    """The scene with the phases that its walls have at a time."""
    box = scene.box
    if box is None or not box.faces:
        return scene
    faces = {}
    for name, face in box.faces.items():
        moves = face.oscillation
        if moves is not None:
            phase = math.remainder(moves.phase + moves.frequency * time, 2 * math.pi)
            face = face.model_copy(update={"oscillation": moves.model_copy(update={"phase": phase})})
        faces[name] = face
    return scene.model_copy(update={"box": box.model_copy(update={"faces": faces})})


def with_output(scene: Scene, method: Method, duration: float, **output: object) -> Scene:
    """The scene with another duration, and with these entries in place of its output.

    scene: what is changed. method: of the run. duration: time. output: entries of `Output`.
    """
    changed = scene.output.model_validate(output)
    return scene.model_copy(update={"duration": duration, "output": changed, "method": method})
