"""The process in which a mutant is judged: `python -P -m crosscheck.mutation.judging`, the mutant first on its path.

It reads requests from stdin, one line of JSON each, and answers on stdout: a case, and how long one call of an engine
may take; its outcome. Nothing of the mutated sources is imported by the process that asks.
"""

from __future__ import annotations

import json
import os
import sys

from crosscheck import runner
from crosscheck.engines.workers import recording
from crosscheck.errors import EngineError


def main() -> None:
    """Answers requests until stdin is closed."""
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)  # what is printed is no answer
        recorder = recording.recorder()
        for line in sys.stdin:
            request = json.loads(line)
            case = runner.Case(**request["case"])
            verdict = runner.judge(case, request["seed"], time_limit=request["limit"])
            red = (
                []
                if verdict.findings is None
                else [one for one in verdict.findings.judgements if one.outcome == "fail"]
            )
            message = verdict.message.partition("\n")[0] or (red[0].quantity if red else "")
            answer = {"outcome": verdict.outcome, "message": message, "seconds": verdict.cost["seconds"]}
            if recorder is not None:
                answer["lines"] = _all_lines(recorder)
            answers.write(json.dumps(answer) + "\n")
            answers.flush()
        runner.close_pools()


def _all_lines(recorder: recording.Recorder) -> dict[str, list[int]]:
    """The lines that the workers and this process executed since the last call."""
    found = {file: set(lines) for file, lines in recorder.take().items()}
    try:
        of_workers = runner.lines_of_workers()
    except EngineError:
        of_workers = {}
    for file, lines in of_workers.items():
        found.setdefault(file, set()).update(lines)
    return {file: sorted(lines) for file, lines in found.items()}


if __name__ == "__main__":
    main()
