"""Operators: the single small changes of a source text that a programmer could make by mistake."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from crosscheck.mutation.syntax import Site, Source, bound_names

#: What an operator puts in place of a node: the node (or another one of the same site) and its new text.
Change = tuple[ast.AST, str]
Operator = Callable[[Source, Site], Iterator[Change]]

#: Types of Python that unions are made of.
_TYPES = {"float", "int", "str", "bool", "tuple", "list", "dict", "bytes"}
#: Relative changes of a constant: 10^-1 to 10^-6.
_POWERS = range(1, 7)
#: Names, or parts of names, that are taken for each other.
_PARTNERS = (
    ("i", "j"), ("x", "y"), ("y", "z"), ("z", "x"), ("a", "b"), ("u", "v"), ("lower", "upper"), ("low", "high"),
    ("left", "right"), ("first", "second"), ("one", "other"), ("row", "column"), ("rows", "columns"), ("up", "down"),
    ("normal", "tangential"), ("before", "after"), ("start", "end"), ("position", "velocity"), ("min", "max"),
)  # fmt: skip
_FLIPPED: dict[type[ast.cmpop], str] = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">"}
_ORDER: dict[type[ast.cmpop], str] = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
_COMPARED: dict[type[ast.cmpop], str] = {
    **_ORDER, ast.Eq: "==", ast.NotEq: "!=", ast.Is: "is", ast.IsNot: "is not", ast.In: "in", ast.NotIn: "not in",
}  # fmt: skip
_OPPOSITE: dict[type[ast.operator], str] = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.BitAnd: "|", ast.BitOr: "&", ast.BitXor: "|",
    ast.LShift: ">>", ast.RShift: "<<",
}  # fmt: skip
_SYMBOL: dict[type[ast.operator], str] = {
    ast.Sub: "-", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.LShift: "<<", ast.RShift: ">>",
}  # fmt: skip


@dataclass(frozen=True)
class Mutation:
    """One change of one source text.

    operator: its name in `OPERATORS`. start, end: the bytes of the text that are replaced. text: what is put there.
    line: where the mutated node starts, from 1. function: the dotted name of the function or class around it, "" for
    the module. first, last: the lines of the statement that a run executes if it executes the mutation. binds: names
    that the statement gives a value outside of functions, when the module is imported; None: it is within a function.
    """

    operator: str
    start: int
    end: int
    text: str
    line: int
    function: str
    first: int
    last: int
    binds: tuple[str, ...] | None


def mutations(source: Source, operators: dict[str, Operator]) -> list[Mutation]:
    """All mutations of a text. source: the text. operators: those to take, by name."""
    found = []
    for site in source.sites():
        for name, operator in operators.items():
            for node, text in operator(source, site):
                start, end = source.span(node)
                line = getattr(node, "lineno", 0)
                first, last = _executed(site)
                found.append(Mutation(name, start, end, text, line, site.scope.name, first, last, _binds(site)))
    return found


def _statement(site: Site) -> ast.stmt:
    return next(one for one in (site.node, *site.parents) if isinstance(one, ast.stmt))


def _executed(site: Site) -> tuple[int, int]:
    """First and last line of the statement, without those that it contains; of a default value, of its function."""
    statement = _statement(site)
    inner = getattr(statement, "body", None)
    if isinstance(statement, ast.FunctionDef):
        return statement.body[0].lineno, statement.end_lineno or statement.lineno
    if not inner:
        return statement.lineno, statement.end_lineno or statement.lineno
    return statement.lineno, max(statement.lineno, inner[0].lineno - 1)


def _binds(site: Site) -> tuple[str, ...] | None:
    """The names bound by a statement of the module or of a class; None within a function."""
    if site.scope.inside:
        return None
    statement = _statement(site)
    if isinstance(statement, ast.FunctionDef):
        return (statement.name,)
    return bound_names(statement)


def _number(node: ast.AST) -> int | float | None:
    """The number that a node is; None for anything else, True and False too."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return node.value
    return None


def _constant(source: Source, site: Site) -> Iterator[Change]:
    """A number times 1 +- 10^-k; an integer +- 1. Indices are for `off_by_one`."""
    value = _number(site.node)
    if value is None or site.in_index:
        return
    if isinstance(value, int):
        yield from ((site.node, _literal(value + change)) for change in (1, -1))
        return
    for power in _POWERS:
        for sign in (1.0, -1.0):
            changed = value * (1.0 + sign * 10.0**-power) if value else sign * 10.0**-power
            yield site.node, _literal(changed)


def _literal(value: float) -> str:
    return f"({value!r})" if value < 0 else repr(value)


def _sign(source: Source, site: Site) -> Iterator[Change]:
    """A minus that is lost, or one too many before a product; `+=` for `-=`."""
    node = site.node
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield node, source.operand(node.operand)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div) and not site.in_index:
        yield node, f"-({source.segment(node)})"
    elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
        symbol = "-" if isinstance(node.op, ast.Add) else "+"
        yield node, f"{source.segment(node.target)} {symbol}= {source.segment(node.value)}"


def _swapped_operands(source: Source, site: Site) -> Iterator[Change]:
    """a - b for b - a, a/b for b/a; a < b for b < a."""
    node = site.node
    if isinstance(node, ast.BinOp) and type(node.op) in _SYMBOL:
        yield node, f"{source.operand(node.right)} {_SYMBOL[type(node.op)]} {source.operand(node.left)}"
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _ORDER:
        symbol = _ORDER[type(node.ops[0])]
        yield node, f"{source.operand(node.comparators[0])} {symbol} {source.operand(node.left)}"


def _comparison(source: Source, site: Site) -> Iterator[Change]:
    """< for <=, > for >=, and back."""
    node = site.node
    if isinstance(node, ast.Compare):
        terms = [source.operand(one) for one in (node.left, *node.comparators)]
        for k, op in enumerate(node.ops):
            if type(op) in _FLIPPED:
                symbols = [_FLIPPED[type(one)] if n == k else _COMPARED[type(one)] for n, one in enumerate(node.ops)]
                yield node, terms[0] + "".join(f" {s} {term}" for s, term in zip(symbols, terms[1:], strict=True))


def _arithmetic(source: Source, site: Site) -> Iterator[Change]:
    """+ for -, times for over, `and` for `or` of bits, left for right shift, and back."""
    node = site.node
    if isinstance(node, ast.BinOp) and type(node.op) in _OPPOSITE and not _is_union(node):
        yield node, f"{source.operand(node.left)} {_OPPOSITE[type(node.op)]} {source.operand(node.right)}"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Invert):
        yield node, source.operand(node.operand)


def _is_union(node: ast.BinOp) -> bool:
    """Whether it is a union of types, as `float | None`."""
    leaves = [one for one in ast.walk(node) if isinstance(one, ast.Name | ast.Constant)]
    types = [
        one.id in _TYPES or one.id.lstrip("_")[:1].isupper() if isinstance(one, ast.Name) else one.value is None
        for one in leaves
    ]
    return isinstance(node.op, ast.BitOr) and all(types)


def _dropped_term(source: Source, site: Site) -> Iterator[Change]:
    """a or b for a + b; a or -b for a - b; the same of the bits of words."""
    node = site.node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub | ast.BitXor | ast.BitOr | ast.BitAnd):
        if _is_union(node):
            return
        yield node, source.operand(node.left)
        minus = "-" if isinstance(node.op, ast.Sub) else ""
        yield node, minus + source.operand(node.right)


def _dropped_factor(source: Source, site: Site) -> Iterator[Change]:
    """a or b for a b; a or 1/b for a/b; a for a power of a."""
    node = site.node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div | ast.FloorDiv | ast.Pow | ast.Mod):
        yield node, source.operand(node.left)
        if isinstance(node.op, ast.Mult):
            yield node, source.operand(node.right)
        elif isinstance(node.op, ast.Div) and _number(node.left) != 1:
            yield node, f"1.0 / {source.operand(node.right)}"


def _off_by_one(source: Source, site: Site) -> Iterator[Change]:
    """An index, or a bound of `range`, that is one too large or too small."""
    node = site.node
    if not site.in_index or isinstance(node, ast.Tuple | ast.Slice | ast.Starred | ast.Call | ast.Compare):
        return
    value = _number(node)
    if isinstance(value, int):
        yield from ((node, _literal(value + change)) for change in (1, -1))
    elif isinstance(node, ast.Name) and site.scope.inside:
        yield from ((node, f"({node.id} {sign} 1)") for sign in "+-")


def _swapped_axis(source: Source, site: Site) -> Iterator[Change]:
    """i for j, x for y, by name, by attribute or as the number of an index."""
    node = site.node
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        for name in _partners(node.id):
            if site.scope.first.get(name, node.lineno) < node.lineno:
                yield node, name
    elif isinstance(node, ast.Attribute):
        for name in _partners(node.attr):
            if name in source.attributes:
                yield node, f"{source.segment(node.value)}.{name}"
    elif site.in_index and _number(node) in (0, 1, 2) and isinstance(site.parents[0], ast.Subscript | ast.Tuple):
        yield node, "0" if _number(node) else "1"


def _partners(name: str) -> list[str]:
    """Names that differ from this one by a partner of one of its parts: vx and vy, mass_i and mass_j, x1 and x2."""
    found = []
    parts = re.split(r"(_|(?<=[a-z])(?=\d)|(?<=^[a-z])(?=[a-z]$)|(?<=\d)(?=[a-z]))", name)
    for one, other in (*_PARTNERS, ("0", "1"), ("1", "2")):
        for this, that in ((one, other), (other, one)):
            for k, part in enumerate(parts):
                if part == this:
                    found.append("".join([*parts[:k], that, *parts[k + 1 :]]))
    return list(dict.fromkeys(found))


def _wrong_branch(source: Source, site: Site) -> Iterator[Change]:
    """A condition that is negated; `and` for `or`, and back."""
    node = site.node
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        test = node.test
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            yield test, source.segment(test.operand)
        elif not isinstance(test, ast.Constant):
            yield test, f"not ({source.segment(test)})"
    elif isinstance(node, ast.BoolOp):
        symbol = " or " if isinstance(node.op, ast.And) else " and "
        yield node, symbol.join(source.operand(one) for one in node.values)


def _skipped_statement(source: Source, site: Site) -> Iterator[Change]:
    """An assignment to what has a value already, a call for its effect, `continue` or `break`: left out."""
    node = site.node
    if isinstance(node, ast.Assign):
        names = [one for target in node.targets for one in ast.walk(target)]
        new = [
            one
            for one in names
            if isinstance(one, ast.Name)
            and isinstance(one.ctx, ast.Store)
            and site.scope.first.get(one.id, node.lineno) >= node.lineno
        ]
        if site.scope.inside and not new:
            yield node, "pass"
    elif isinstance(node, ast.Continue | ast.Break) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield node, "pass"


def _missing_update(source: Source, site: Site) -> Iterator[Change]:
    """`a += b` left out."""
    if isinstance(site.node, ast.AugAssign):
        yield site.node, "pass"


def _stale_variable(source: Source, site: Site) -> Iterator[Change]:
    """Another variable of the function that is used in the same way, and has a value there."""
    node, scope = site.node, site.scope
    if not (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in scope.first):
        return
    uses, annotation = scope.uses.get(node.id, set()), scope.annotations.get(node.id)
    for name, line in sorted(scope.first.items()):
        same_annotation = annotation is not None and annotation == scope.annotations.get(name)
        other = scope.uses.get(name, set())
        alike = same_annotation or (uses & other and "callee" not in uses | other)
        if name != node.id and alike and line < node.lineno:
            yield node, name


#: The operators that change results, by name.
OPERATORS: dict[str, Operator] = {
    "constant": _constant,
    "sign": _sign,
    "swapped operands": _swapped_operands,
    "comparison": _comparison,
    "arithmetic": _arithmetic,
    "dropped term": _dropped_term,
    "dropped factor": _dropped_factor,
    "off by one": _off_by_one,
    "swapped axis or particle": _swapped_axis,
    "wrong branch": _wrong_branch,
    "skipped statement": _skipped_statement,
    "missing update": _missing_update,
    "stale variable": _stale_variable,
}

#: Names of what decides how much is looked at, kept or built at a time, and of functions that look or build.
_SIZES = re.compile(r"capacity|skin|close|fine|margin|slack|spare|growth|batch|bucket|many|per_", re.I)
_BUILDS = re.compile(r"refresh|renew|rebuild|prune|moved|make_list|up_to_date", re.I)


def _other_size(source: Source, site: Site) -> Iterator[Change]:
    """A capacity, a skin or another size of lists and cells that is twice or half as large."""
    value = _number(site.node)
    factor = isinstance(site.parents[0], ast.BinOp) and isinstance(site.parents[0].op, ast.Mult)
    bound = isinstance(site.parents[0], ast.Assign) and not site.scope.inside
    if not value or site.in_index or not (factor or bound) or not _SIZES.search(source.segment(_statement(site))):
        return
    for change in (2.0, 0.5):
        yield site.node, _literal(math.ceil(value * change) if isinstance(value, int) else value * change)


def _dropped_shortcut(source: Source, site: Site) -> Iterator[Change]:
    """A `continue`, a `break` or an early `return` without a value, which saves work: left out."""
    node = site.node
    early = isinstance(node, ast.Return) and node.value is None
    if isinstance(node, ast.Continue | ast.Break) or early:
        yield node, "pass"


def _widened_search(source: Source, site: Site) -> Iterator[Change]:
    """A search among neighbours that goes one cell further, or a cell that begins one sooner."""
    node, parent = site.node, site.parents[0]
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub) and _number(node.right) == 1):
        return
    bound = (
        site.in_index
        and isinstance(parent, ast.Call)
        and len(parent.args) == 2
        and _number(parent.args[0]) is None
        and node is parent.args[1]
    )
    if bound or (isinstance(parent, ast.Tuple) and isinstance(site.parents[1], ast.Assign)):
        yield node, f"{source.operand(node.left)} {'+' if isinstance(node.op, ast.Add) else '-'} 2"


def _always_done(source: Source, site: Site) -> Iterator[Change]:
    """Lists that are built, or events that are predicted, whether they have to be or not."""
    node = site.node
    if isinstance(node, ast.If) and (_BUILDS.search(site.scope.name) or _BUILDS.search(source.segment(node.test))):
        yield node.test, "True"


#: The operators that should change the cost alone, by name.
COST_OPERATORS: dict[str, Operator] = {
    "other size": _other_size,
    "dropped shortcut": _dropped_shortcut,
    "widened search": _widened_search,
    "always done": _always_done,
}
