"""How much a file has rounded its numbers, read off the decimals that it prints.

What a rounding has changed uses all digits of its format, but for a zero at the end, which one of ten numbers has, and
which "%g" drops. So a few dozen different numbers tell the format: how many decimals or significant digits, and whether
they had 32 bits before they were printed.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, SINGLE, Rounding

#: Significant digits with which a decimal number reads back to the same double, and those of C's "%g".
_EXACT, _USUAL = 17, 6
#: Significant digits with which a decimal number reads back to the same number of 32 bits.
_SHORTEST = 9
#: Different words that tell a format for certain. Fewer may be sites of a lattice, or masses, which are what they look
#: like: then six digits are assumed, which "%g" has.
_MANY = 20
#: Decimals that are nobody's way to write an exact number: as in 0.5000.
_PADDED = 4
#: Share of numbers that use all digits of their format, at least, and different last digits that rounded numbers have.
_SHARE, _LAST = 0.75, 5
#: Fewer significant digits are those of a lattice, unless numbers of several magnitudes have them.
_FEW = 4
#: Bits of a number above which it is no accident that 32 bits hold it: a site of a lattice needs fewer.
_BITS = 18


class _Word(NamedTuple):
    """A printed number. places: decimals. digits: significant digits. magnitude: power of ten of the first of them.
    exponent: whether it has one. last: its last digit."""

    places: int
    digits: int
    magnitude: int
    exponent: bool
    last: str


def of_decimals(words: Collection[str]) -> Rounding:
    """The rounding of numbers that are printed as these words, some of one quantity.

    With the same number of decimals ("%.8f"): half a unit of the last one. Else ("%g"), half a unit of the last of as
    many significant digits as the longest number has; where both can be, both together. With 17 digits, as doubles that
    read back to the same bits have: that of doubles. Half a unit of 24 bits is added if the numbers had 32 bits before
    they were printed, as all of them show: printed from 32 bits again, they are the same words.
    """
    different = sorted({word for word in words if np.isfinite(float(word))})
    if not different:
        return DOUBLE
    parsed = [_parsed(word) for word in different]
    found = _of_format(parsed)
    values = np.array([float(word) for word in different])
    if _were_single(values, different, parsed):
        if 7 < max(word.digits for word in parsed) <= _SHORTEST and not found.absolute:  # they tell 32 bits apart
            return Rounding(0.0, 2 * SINGLE.relative, SINGLE.name)
        coarse = found.relative > SINGLE.relative or found.absolute > SINGLE.relative * np.abs(values).max()
        return found._replace(relative=found.relative + SINGLE.relative, name=found.name if coarse else SINGLE.name)
    return found


def coarsest(roundings: Collection[Rounding]) -> Rounding:
    """What bounds the rounding of numbers that have one of several. roundings: one or more."""
    absolute, relative = max(one.absolute for one in roundings), max(one.relative for one in roundings)
    name = max(roundings, key=lambda one: one.absolute + one.relative).name
    return Rounding(absolute, relative, name)


def scaled(rounding: Rounding, vectors: np.ndarray, lower: np.ndarray, largest: float) -> Rounding:
    """The rounding of positions that are printed as fractions of a box.

    rounding: of the fractions. vectors: edges of the box as rows, (3, 3), length. lower: its lower corner, (3,),
    length. largest: the largest |fraction|.
    """
    edges = np.abs(vectors).sum(axis=0).max()  # of the largest component of a position
    absolute = (rounding.absolute + rounding.relative * max(largest, 1.0)) * edges
    rounds = DOUBLE.relative * (4 * edges + np.abs(lower).max())  # products and sums
    # fractions of more than `largest` grow with the position
    return Rounding(absolute + rounds, rounding.relative + 4 * DOUBLE.relative, f"{rounding.name} of the box")


def unwrapped(rounding: Rounding, vectors: np.ndarray) -> Rounding:
    """The rounding of positions to which images of a box were added. rounding: of the positions. vectors: (3, 3)."""
    edges = np.abs(vectors).sum(axis=0).max()
    relative = rounding.relative + 4 * DOUBLE.relative
    return rounding._replace(absolute=rounding.absolute + relative * edges, relative=relative)


def _parsed(word: str) -> _Word:
    mantissa, _, exponent = word.lower().partition("e")
    whole, _, decimals = mantissa.lstrip("+-").partition(".")
    number = whole + decimals
    digits = len(number.lstrip("0"))
    return _Word(len(decimals), digits, digits - len(decimals) + int(exponent or 0), bool(exponent), number[-1:])


def _of_format(words: list[_Word]) -> Rounding:
    """The rounding of the format of these different words."""
    many = len(words) >= _MANY
    digits = max(word.digits for word in words)
    places = {word.places for word in words}
    decimals = min(places) if len(places) == 1 else 0
    exponents = {word.exponent for word in words}
    if decimals and exponents == {True} and many:  # "%.8e"
        return _significant(decimals + 1)
    fixed = decimals and exponents == {False} and _is_fixed(words, decimals, many)
    if fixed:
        rounding = Rounding(0.5 * 10.0**-decimals, DOUBLE.relative, f"{decimals} decimals")
        zeros = any(word.last == "0" for word in words)
        if zeros or len({word.digits for word in words}) > 1:
            return rounding
        # numbers of one decade, none of which ends in 0: "%g" would print the same
        return rounding._replace(relative=_significant(digits).relative)
    full = [word for word in words if word.digits == digits]
    told = many and len(full) >= _SHARE * len(words)
    told &= digits >= _FEW or len({word.magnitude for word in full}) > 1
    return _significant(digits if told else max(digits, _USUAL)) if digits else DOUBLE


def _is_fixed(words: list[_Word], decimals: int, many: bool) -> bool:
    """Whether words with the same number of decimals are printed with a fixed number of them."""
    padded = decimals > 1 and any(word.last == "0" for word in words)
    if decimals >= _PADDED:
        return padded or len(words) > 2
    nothing = all(word.digits == 0 for word in words)  # 0.00
    return (padded and (many or nothing)) or (many and len({word.last for word in words}) >= _LAST)


def _significant(digits: int) -> Rounding:
    """Half a unit of the last of so many significant digits."""
    if digits >= _EXACT:
        return DOUBLE
    return Rounding(0.0, 0.5 * 10.0 ** (1 - digits) + DOUBLE.relative, f"{digits} significant digits")


def _were_single(values: np.ndarray, words: list[str], parsed: list[_Word]) -> bool:
    """Whether all these numbers had 32 bits before they were printed, as far as it matters."""
    with np.errstate(over="ignore", under="ignore"):
        single = values.astype(np.float32)
    mantissas, _ = np.frexp(values)
    long = np.ldexp(mantissas, _BITS) % 1 != 0
    if not long.any():
        return False
    digits = max(word.digits for word in parsed)
    for value, word, how in zip(single, words, parsed, strict=True):
        number = float(word)
        forms = {
            f"{float(value):.{max(digits - 1, 0)}e}",
            f"{float(value):.{how.places}{'e' if how.exponent else 'f'}}",
        }
        if digits <= _SHORTEST:
            forms.add(str(value))
        if all(float(form) != number for form in forms):
            return False
    return True
