"""Where short runs for an audit begin: where the run began, and where it ended."""

from __future__ import annotations

from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene, explicit
from crosscheck.simulate.judging.trial import Trial


def from_start_and_end(trial: Trial) -> list[tuple[str, Scene]]:
    """The scene with the initial state that it has, and with the state at the end of the run; in words, where.

    The second one is left out where it is no state to begin with, as when hard spheres overlap by more than rounding.
    trial: the run.
    """
    found = [("from the start", trial.scene)]
    if not trial.broken:
        run = trial.run
        last = explicit(run["final_positions"], run["final_velocities"], run.get("final_angular_velocities"))
        end = trial.scene.model_copy(update={"initial": last, "seed": trial.seed})
        try:
            end.own_start()
        except UsageError:
            return found
        found.append(("from the end", end))
    return found


def with_output(scene: Scene, method: Method, duration: float, **output: object) -> Scene:
    """The scene with another duration, and with these entries in place of its output.

    scene: what is changed. method: of the run. duration: time. output: entries of `Output`.
    """
    changed = scene.output.model_validate(output)
    return scene.model_copy(update={"duration": duration, "output": changed, "method": method})
