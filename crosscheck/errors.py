"""The exceptions of the suite. The command line shows them as a message without a traceback."""


class UsageError(Exception):
    """A mistake that the user can correct: the message says what is wrong, where, and how to mend it. Exit status 2."""


class EngineMissing(Exception):
    """The engine cannot run on this machine; the message says why. Its cases are skipped."""


class EngineError(Exception):
    """The engine failed, crashed or ran past its time limit; the message holds its last lines."""


class EndedEarly(Exception):
    """The engine under judgement ended a run before its time; the message says which, and why. The case is red."""


class Unsupported(Exception):
    """The engine cannot run this scene with this method; the message says why. The case is skipped."""
