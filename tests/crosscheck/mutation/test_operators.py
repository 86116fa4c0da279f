"""Each mutation is Python, and differs from the original in one place, the one that it names."""

from __future__ import annotations

import ast
import random
from pathlib import Path

import pytest

import refimpl
from crosscheck.mutation.operators import COST_OPERATORS, OPERATORS, Mutation, mutations
from crosscheck.mutation.syntax import Source

RULES = Path(refimpl.__path__[0]) / "events" / "rules.py"


def texts(source: str, operator: str) -> set[str]:
    """What an operator makes of a source."""
    text = Source(source)
    found = mutations(text, {operator: OPERATORS[operator]})
    return {text.replaced(one.start, one.end, one.text) for one in found}


def place(before: ast.AST, after: ast.AST) -> tuple[ast.AST, ast.AST] | None:
    """The smallest two subtrees outside of which both trees are the same; None if there is no difference."""
    if type(before) is not type(after):
        return before, after
    differing = []
    for name in before._fields:
        one, other = getattr(before, name, None), getattr(after, name, None)
        pairs = list(zip(one, other, strict=False)) if isinstance(one, list) else [(one, other)]
        if isinstance(one, list) and len(one) != len(other):
            return before, after
        for a, b in pairs:
            if isinstance(a, ast.AST) and isinstance(b, ast.AST):
                inner = place(a, b)
                differing += [] if inner is None else [inner]
            elif a != b or type(a) is not type(b):
                return before, after
    return (before, after) if len(differing) > 1 else next(iter(differing), None)


@pytest.mark.parametrize("path", ["events/rules.py", "lattice/kernels/planes.py", "stepping/schemes.py"])
def test_a_mutant_is_python_and_differs_in_one_place(path: str) -> None:
    source = Source((Path(refimpl.__path__[0]) / path).read_text())
    found = mutations(source, OPERATORS | COST_OPERATORS)
    for one in random.Random(1).sample(found, 60):
        tree = ast.parse(source.replaced(one.start, one.end, one.text))
        changed = place(source.tree, tree)
        assert changed is not None, one
        before = changed[0]
        if isinstance(before, ast.expr | ast.stmt):
            start, end = source.span(before)
            inside = one.start <= start and end <= one.end  # within what was replaced
            around = start <= one.start and one.end <= end and one.end - one.start > 0.2 * (end - start)
            assert inside or around, one


@pytest.mark.parametrize(
    ("operator", "source", "some"),
    [
        ("constant", "a = 2.0\n", ["a = 2.2\n", "a = 1.999998\n"]),
        ("constant", "a = 3\n", ["a = 4\n", "a = 2\n"]),
        ("sign", "a = -b\n", ["a = b\n"]),
        ("sign", "a = b * c\n", ["a = -(b * c)\n"]),
        ("sign", "a += b\n", ["a -= b\n"]),
        ("swapped operands", "a = b - (c + d)\n", ["a = ((c + d) - b)\n", "a = (c + d) - b\n"]),
        ("swapped operands", "a = b < c\n", ["a = c < b\n"]),
        ("comparison", "a = b < c\n", ["a = b <= c\n"]),
        ("comparison", "a = b < c <= d\n", ["a = b <= c <= d\n", "a = b < c < d\n"]),
        ("arithmetic", "a = b + c\n", ["a = b - c\n"]),
        ("dropped term", "a = b - c\n", ["a = b\n", "a = -c\n"]),
        ("dropped factor", "a = b / c\n", ["a = b\n", "a = 1.0 / c\n"]),
        ("off by one", "def f(a, i):\n    return a[i]\n", ["def f(a, i):\n    return a[(i + 1)]\n"]),
        ("off by one", "for k in range(3):\n    pass\n", ["for k in range(4):\n    pass\n"]),
        ("swapped axis or particle", "def f(x, y):\n    return x + y\n", ["def f(x, y):\n    return y + y\n"]),
        ("swapped axis or particle", "def f(a):\n    return a[0]\n", ["def f(a):\n    return a[1]\n"]),
        ("wrong branch", "if a:\n    b()\n", ["if not (a):\n    b()\n"]),
        ("wrong branch", "a = b and c\n", ["a = b or c\n"]),
        ("skipped statement", "def f(a):\n    a[0] = 1\n", ["def f(a):\n    pass\n"]),
        ("missing update", "a += 1\n", ["pass\n"]),
        ("stale variable", "def f(a, b, i):\n    return a[i] + b[i]\n", ["def f(a, b, i):\n    return b[i] + b[i]\n"]),
    ],
)
def test_what_an_operator_does(operator: str, source: str, some: list[str]) -> None:
    found = texts(source, operator)
    assert any(one in found for one in some), found
    if len(some) > 1 and operator != "swapped operands":
        assert set(some) <= found


@pytest.mark.parametrize(
    "source",
    [
        '"""2.0 + 3"""\n',
        "from a import b\n",
        "def f(a: int | None) -> tuple[int, 3]:\n    return a\n",
        "def f(a):\n    if a < 0:\n        raise ValueError(a + 1)\n",
        "class A:\n    def __repr__(self):\n        return 1 + 2\n",
        "Number = float | int\n",
        "@njit(cache=True, level=2)\ndef f():\n    pass\n",
    ],
)
def test_what_is_for_people_is_left_alone(source: str) -> None:
    assert [one for name in OPERATORS for one in texts(source, name)] == []


def test_a_first_assignment_is_not_skipped() -> None:
    # a name without a value is no mistake that anybody would overlook
    assert texts("def f():\n    a = 1\n    return a\n", "skipped statement") == set()
    assert texts("def f():\n    a = 1\n    a = 2\n    return a\n", "skipped statement") == {
        "def f():\n    a = 1\n    pass\n    return a\n"
    }


def test_a_mutation_names_the_lines_that_execute_it_and_the_names_that_it_binds() -> None:
    source = "A = 1.5\n\n\ndef f(b=2):\n    if (b\n            > 3):\n        b = 4\n    return b\n"
    found = {one.line: one for one in mutations(Source(source), {"constant": OPERATORS["constant"]})}
    assert [(one.first, one.last, one.binds) for one in found.values()] == [
        (1, 1, ("A",)),
        (5, 8, ("f",)),
        (5, 6, None),
        (7, 7, None),
    ]
    assert [one.function for one in found.values()] == ["", "", "f", "f"]


def test_all_operators_apply_to_the_rules_of_collisions() -> None:
    found: list[Mutation] = mutations(Source(RULES.read_text()), OPERATORS)
    assert {one.operator for one in found} == set(OPERATORS)
