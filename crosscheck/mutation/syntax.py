"""A source file as a tree of syntax, with the places where a mutation may be, and what is known of each."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
#: Functions whose text is for people only.
_FOR_PEOPLE = {"__repr__", "__str__"}
#: Syntax that needs no parentheses, whatever is around it.
_ATOMS = (ast.Name, ast.Constant, ast.Attribute, ast.Subscript, ast.Call, ast.Tuple, ast.List, ast.Dict)


@dataclass
class Scope:
    """What a function, or a module, knows of its variables.

    name: of the function, dotted; "" of the module. first: the line where each of its own variables is first bound; of
    an argument, 0.
    uses: how each is used: "index", "term", "array", "callee", "test", and ".name" for each attribute that is read of
    it. annotations: of the arguments, but for Any. inside: whether it is a function.
    """

    name: str
    first: dict[str, int] = field(default_factory=dict)
    uses: dict[str, set[str]] = field(default_factory=dict)
    annotations: dict[str, str] = field(default_factory=dict)
    inside: bool = False


@dataclass(frozen=True)
class Site:
    """A node of the tree that may be mutated.

    node: itself. parents: the nodes around it, the innermost first, up to the function or module. scope: of its
    function.
    """

    node: ast.AST
    parents: tuple[ast.AST, ...]
    scope: Scope

    @property
    def in_index(self) -> bool:
        """Whether it lies in the index of an array, or is a bound of `range`, whatever is computed around it."""
        inner: ast.AST = self.node
        for parent in self.parents:
            if isinstance(parent, ast.Subscript):
                return inner is parent.slice
            if isinstance(parent, ast.Call):
                return isinstance(parent.func, ast.Name) and parent.func.id == "range"
            if not isinstance(parent, ast.BinOp | ast.UnaryOp | ast.Tuple | ast.Slice):
                return False
            inner = parent
        return False


class Source:
    """The text of a module, and its sites. text: Python; SyntaxError if it is not."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tree = ast.parse(text)
        self._bytes = text.encode()
        self._starts = [0, *accumulate(len(line.encode()) for line in text.splitlines(keepends=True))]

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Start and end of a node in the encoded text, bytes. node: an expression or a statement."""
        assert isinstance(node, ast.expr | ast.stmt)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self._starts[node.lineno - 1] + node.col_offset, self._starts[node.end_lineno - 1] + node.end_col_offset

    def segment(self, node: ast.AST) -> str:
        """The text of a node; node: an expression or a statement."""
        start, end = self.span(node)
        return self._bytes[start:end].decode()

    def operand(self, node: ast.AST) -> str:
        """The text of an expression, in parentheses unless it is an atom. node: the expression."""
        text = self.segment(node)
        return text if isinstance(node, _ATOMS) else f"({text})"

    def replaced(self, start: int, end: int, text: str) -> str:
        """The whole text with `text` in place of the bytes from `start` to `end`."""
        return (self._bytes[:start] + text.encode() + self._bytes[end:]).decode()

    @cached_property
    def attributes(self) -> frozenset[str]:
        """Names of all attributes that occur in the module."""
        return frozenset(node.attr for node in ast.walk(self.tree) if isinstance(node, ast.Attribute))

    def sites(self) -> Iterator[Site]:
        """All sites: not docstrings, annotations, imports, decorators, errors and the tests that raise them."""
        module = _scope("", self.tree)
        yield from _visit_all(self.tree.body, (self.tree,), module)


def bound_names(statement: ast.stmt) -> tuple[str, ...]:
    """The names that a statement assigns to. statement: any."""
    names = (node for node in ast.walk(statement) if isinstance(node, ast.Name))
    return tuple(name.id for name in names if isinstance(name.ctx, ast.Store))


def _visit_all(nodes: list[ast.stmt] | list[ast.expr], parents: tuple[ast.AST, ...], scope: Scope) -> Iterator[Site]:
    for node in nodes:
        yield from _visit(node, parents, scope)


def _visit(node: ast.AST, parents: tuple[ast.AST, ...], scope: Scope) -> Iterator[Site]:
    if isinstance(node, _FUNCTIONS):
        if node.name not in _FOR_PEOPLE:
            inner = _scope(f"{scope.name}.{node.name}".lstrip("."), node)
            given = [*node.args.defaults, *(one for one in node.args.kw_defaults if one is not None)]
            yield from _visit_all(given, (node, *parents), scope)
            yield from _visit_all(node.body, (node,), inner)
    elif isinstance(node, ast.ClassDef):
        yield from _visit_all(node.body, (node,), Scope(f"{scope.name}.{node.name}".lstrip(".")))
    elif isinstance(node, ast.If) and _is_guard(node):
        yield from _visit_all(node.orelse, (node, *parents), scope)
    elif not _is_for_people(node):
        if isinstance(node, ast.stmt | ast.expr):
            yield Site(node, parents, scope)
        for name, value in ast.iter_fields(node):
            if name == "annotation":
                continue
            for one in value if isinstance(value, list) else [value]:
                if isinstance(one, ast.AST):
                    yield from _visit(one, (node, *parents), scope)


def _is_for_people(node: ast.AST) -> bool:
    """Whether the node is text for people, for type checkers, or reports an error."""
    if isinstance(node, ast.Import | ast.ImportFrom | ast.Raise | ast.Assert | ast.JoinedStr | ast.expr_context):
        return True
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str | bytes)
    return isinstance(node, ast.AnnAssign) and node.value is None


def _is_guard(node: ast.If) -> bool:
    """Whether the branch does nothing but refuse bad input, or is there for type checkers."""
    if isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        return True
    return all(isinstance(one, ast.Raise) for one in node.body)


def _scope(name: str, node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Module) -> Scope:
    scope = Scope(name, inside=isinstance(node, _FUNCTIONS))
    if isinstance(node, _FUNCTIONS):
        for given in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]:
            scope.first[given.arg] = 0
            text = "Any" if given.annotation is None else ast.unparse(given.annotation)
            if text != "Any":
                scope.annotations[given.arg] = text
    body: list[ast.AST] = list(node.body)
    while body:
        one = body.pop()
        if isinstance(one, (*_FUNCTIONS, ast.ClassDef, ast.Lambda)):
            continue
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store):
            scope.first[one.id] = min(one.lineno, scope.first.get(one.id, one.lineno))
        for kind, used in _uses(one):
            scope.uses.setdefault(used, set()).add(kind)
        body.extend(ast.iter_child_nodes(one))
    return scope


def _uses(node: ast.AST) -> Iterator[tuple[str, str]]:
    """How the node uses the names directly below it."""
    found: list[tuple[str, ast.AST]] = []
    if isinstance(node, ast.Subscript):
        inner = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        found = [("array", node.value), *(("index", one) for one in inner)]
    elif isinstance(node, ast.BinOp):
        found = [("term", node.left), ("term", node.right)]
    elif isinstance(node, ast.Compare):
        numbers = not any(isinstance(one, ast.Is | ast.IsNot | ast.In | ast.NotIn) for one in node.ops)
        found = [("term", one) for one in (node.left, *node.comparators)] if numbers else []
    elif isinstance(node, ast.Attribute):
        found = [(f".{node.attr}", node.value)]
    elif isinstance(node, ast.Call):
        found = [("callee", node.func)]
    elif isinstance(node, ast.If | ast.While | ast.IfExp):
        found = [("test", node.test)]
    for kind, one in found:
        if isinstance(one, ast.Name):
            yield kind, one.id
