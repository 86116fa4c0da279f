"""The process in which a mutant is judged: `python -P -m crosscheck.mutation.judging`, the mutant first on its path.

It reads requests from stdin, one line of JSON each, and answers on stdout: a case, and how long one call of an engine
may take; its outcome. Nothing of the mutated sources is imported by the process that asks.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from crosscheck import runner
from crosscheck.engines.registry import engine_class
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
            answer = _answer(case, request["seed"], request["limit"])
            if recorder is not None:
                answer["lines"] = _all_lines(recorder)
            answers.write(json.dumps(answer) + "\n")
            answers.flush()
        runner.close_pools()


def _answer(case: runner.Case, seed: int, limit: float) -> dict[str, Any]:
    if not _is_offered(case):
        return {"outcome": "skip", "message": "the mutated sources do not offer this case", "seconds": 0.0}
    verdict = runner.judge(case, seed, time_limit=limit)
    red = [] if verdict.findings is None else [one for one in verdict.findings.judgements if one.outcome == "fail"]
    message = verdict.message.partition("\n")[0] or (red[0].quantity if red else "")
    return {"outcome": verdict.outcome, "message": message, "seconds": verdict.cost["seconds"]}


def _is_offered(case: runner.Case) -> bool:
    """Whether the mutated sources still declare what the case needs: if not, nobody would run it."""
    variants = runner.judging(runner.find(case.check), case.engine, engine_class(case.engine))
    return any(one.name == case.variant for one in variants)


def _all_lines(recorder: recording.Recorder) -> recording.Executed:
    """The lines that the workers and this process executed since the last call."""
    own = recorder.take()
    try:
        return recording.merged([own, runner.lines_of_workers()])
    except EngineError:
        return own


if __name__ == "__main__":
    main()
