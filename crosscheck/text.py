"""Text of users and of files, as it may be shown: nothing in it breaks a line, a terminal or a file format."""

from __future__ import annotations

import re

#: Control characters, the line ends that are none in a file of lines, halves of surrogate pairs (which stand for bytes
#: that are not UTF-8) and the two non-characters that XML refuses.
_HIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")


def printable(text: str, keep: str = "") -> str:
    r"""The text with its control characters and surrogates as escapes, such as \n, \x1b and \udcff: nothing is lost.

    keep: characters that stay as they are, such as "\n".
    """
    return _HIDDEN.sub(lambda m: m[0] if m[0] in keep else m[0].encode("unicode_escape").decode("ascii"), text)


def shortened(text: str, most: int = 60) -> str:
    """The text on one line, and of a long one the beginning and its length. most: characters that are shown."""
    line = printable(text[: most + 1])
    return line if len(text) <= most else f"{printable(text[:most])}... ({len(text)} characters)"
