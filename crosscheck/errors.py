"""Errors that a user can mend: shown as one line, exit status 2, no traceback."""


class UsageError(Exception):
    """Bad input or bad usage: the message names what, where and the mend."""


class EngineMissing(Exception):
    """The engine cannot run on this machine; the message says why."""


class EngineError(Exception):
    """The engine failed, crashed or ran past its time limit; the message holds its last lines."""


class Unsupported(Exception):
    """The engine cannot run this scene with this method; the message says why."""
