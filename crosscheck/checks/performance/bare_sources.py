"""The sources of `refimpl` as they would be if a feature had never been written: cut out wherever they ask for it.

Features that a scene does not have are fields that are None. Here every test of such a name against None is decided,
and the branch that is not taken is removed, mechanically, from a copy of the sources. What numba makes of that copy is
what a kernel costs that was written for the scene alone: the real one must not cost more.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from pathlib import Path

from crosscheck.faults import copy_sources


def copy_without(sources: Path, directory: Path, absent: Iterable[str]) -> int:
    """Writes a copy of a package without features; returns how many tests were decided.

    sources: directory of the package. directory: where its copy is made, under the package's own name. absent: names of
    variables and fields that are None.
    """
    copy = copy_sources(sources, directory)
    decided = 0
    for file in copy.rglob("*.py"):
        cutter = _Cutter(frozenset(absent))
        tree = cutter.visit(ast.parse(file.read_text(encoding="utf-8")))
        if cutter.decided:
            file.write_text(ast.unparse(ast.fix_missing_locations(tree)) + "\n", encoding="utf-8")
            decided += cutter.decided
    return decided


class _Cutter(ast.NodeTransformer):
    """Decides all tests of the names in `absent` against None, and removes the branches that are never taken."""

    def __init__(self, absent: frozenset[str]) -> None:
        self._absent = absent
        self.decided = 0

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        """`name is None` is True, `name is not None` is False."""
        match node:
            case ast.Compare(
                left=ast.Name(id=name) | ast.Attribute(attr=name),
                ops=[ast.Is() | ast.IsNot() as test],
                comparators=[ast.Constant(value=None)],
            ) if name in self._absent:
                self.decided += 1
                return ast.Constant(isinstance(test, ast.Is))
        return self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        """`not True` is False."""
        self.generic_visit(node)
        if isinstance(node.op, ast.Not) and _decided(node.operand) is not None:
            return ast.Constant(not _decided(node.operand))
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        """Operands that decide nothing are dropped; one that decides all ends the row."""
        self.generic_visit(node)
        deciding = isinstance(node.op, ast.Or)
        left: list[ast.expr] = []
        for operand in node.values:
            value = _decided(operand)
            if value is None or (value is deciding and left):
                left.append(operand)
            elif value is deciding:
                return operand
        if not left:
            return ast.Constant(not deciding)
        return left[0] if len(left) == 1 else ast.BoolOp(node.op, left)

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        """The branch that is taken."""
        self.generic_visit(node)
        value = _decided(node.test)
        return node if value is None else (node.body if value else node.orelse)

    def visit_If(self, node: ast.If) -> ast.AST | list[ast.stmt]:
        """The statements of the branch that is taken."""
        self.generic_visit(node)
        value = _decided(node.test)
        if value is None:
            return node
        return (node.body if value else node.orelse) or [ast.Pass()]


def _decided(node: ast.expr) -> bool | None:
    """The value of a constant test; None of any other."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, bool) else None
