"""Statements of a kernel as lines of JavaScript, with the kinds of its names followed from line to line."""

from __future__ import annotations

import ast
import types
from collections.abc import Callable, Sequence

from rss_gym.javascript import arrays
from rss_gym.javascript.arithmetic import as_number, binary, stored
from rss_gym.javascript.expressions import Constant, Expressions, Function
from rss_gym.javascript.kinds import (
    INT,
    NOTHING,
    Array,
    Kind,
    Known,
    Lost,
    Record,
    TranslationError,
    Tuple,
    Value,
    described,
    joined,
    of_element,
)

RESERVED = frozenset(
    "arguments async await break case catch class const continue debugger default delete do else enum eval export "
    "extends false finally for function if implements import in instanceof interface let new null package private "
    "protected public return static super switch this throw true try typeof undefined var void while with yield "
    "BigInt Math Number Boolean Array Infinity NaN Float64Array Float32Array Uint8Array BigUint64Array".split()
)
Names = dict[str, Value]


class Statements:
    """Translates the body of one function for arguments of given kinds.

    Attributes
    ----------
    returned : Kind
        What the function returns.
    """

    def __init__(self, function: types.FunctionType, constant: Constant, translated: Function) -> None:
        self._expressions = Expressions(function, constant, translated)
        self._declared: list[str] = []  # names of JavaScript, in order
        self._temporaries = 0
        self._exits: list[list[Names]] = []  # names where a loop is left or gone on with early
        self._returns: list[Kind] = []
        self._line = 0

    def body(self, node: ast.FunctionDef, kinds: Sequence[Kind]) -> str:
        """Parameters and body of the function, from its parenthesis on."""
        parameters = node.args
        if parameters.vararg or parameters.kwarg or parameters.kwonlyargs or parameters.defaults:
            raise TranslationError(f"{node.name}: only plain parameters are known")
        names = [parameter.arg for parameter in (*parameters.posonlyargs, *parameters.args)]
        if len(names) != len(kinds):
            raise TranslationError(f"{node.name}: {len(kinds)} arguments for {len(names)} parameters")
        for name, kind in zip(names, kinds, strict=True):
            if isinstance(kind, Known):
                raise TranslationError(f"{node.name}: a function or type as the argument {name!r} is not known")
            self._expressions.names[name] = Value(_safe(name), kind)
        try:
            lines = self._block(node.body)
        except TranslationError as error:
            if str(error).startswith(f"{node.name}, line"):
                raise
            raise TranslationError(f"{node.name}, line {self._line}: {error}") from error
        declared = [name for name in dict.fromkeys(self._declared) if name not in map(_safe, names)]
        head = [f"let {', '.join(declared)};"] if declared else []
        return f"({', '.join(map(_safe, names))}) {{\n" + "".join(f"  {line}\n" for line in head + lines) + "}"

    @property
    def returned(self) -> Kind:
        """Kind of what the function returns."""
        kind: Kind | None = self._returns[0] if self._returns else NOTHING
        for other in self._returns[1:]:
            kind = joined(kind, other) if kind is not None else None
        if kind is None:
            raise TranslationError(f"a function that returns {' or '.join(map(described, self._returns))} is not known")
        return kind

    # -- blocks -------------------------------------------------------------------------------------------------------

    def _block(self, statements: Sequence[ast.stmt]) -> list[str]:
        lines: list[str] = []
        for statement in statements:
            self._line = statement.lineno
            method: Callable[..., list[str]] | None = getattr(self, f"_on_{type(statement).__name__.lower()}", None)
            if method is None:
                raise TranslationError(f"{type(statement).__name__} is not known")
            lines += method(statement)
            if isinstance(statement, (ast.Return, ast.Break, ast.Continue)):
                self._expressions.names = {}  # nothing comes after it
                break
        return lines

    def _on_expr(self, node: ast.Expr) -> list[str]:
        if isinstance(node.value, ast.Constant):  # the docstring
            return []
        return [f"{self._expressions.value(node.value).code};"]

    def _on_pass(self, node: ast.Pass) -> list[str]:
        return []

    def _on_return(self, node: ast.Return) -> list[str]:
        if node.value is None:
            self._returns.append(NOTHING)
            return ["return;"]
        value = self._expressions.value(node.value)
        self._returns.append(value.kind)
        return [f"return {value.code};"]

    def _on_break(self, node: ast.Break) -> list[str]:
        self._exits[-1].append(dict(self._expressions.names))
        return ["break;"]

    def _on_continue(self, node: ast.Continue) -> list[str]:
        self._exits[-1].append(dict(self._expressions.names))
        return ["continue;"]

    def _on_if(self, node: ast.If) -> list[str]:
        test = self._expressions.condition(node.test)
        before = dict(self._expressions.names)
        then = self._block(node.body)
        after, self._expressions.names = self._expressions.names, before
        other = self._block(node.orelse)
        self._expressions.names = _merged(after, self._expressions.names)
        lines = [f"if ({test}) {{", *_indented(then)]
        return [*lines, "} else {", *_indented(other), "}"] if other else [*lines, "}"]

    def _on_while(self, node: ast.While) -> list[str]:
        if node.orelse:
            raise TranslationError("else after a loop is not known")

        def inside() -> list[str]:
            test = self._expressions.condition(node.test)
            return [f"while ({test}) {{", *_indented(self._block(node.body)), "}"]

        return self._loop(inside, forever=isinstance(node.test, ast.Constant))

    def _on_for(self, node: ast.For) -> list[str]:
        if node.orelse or not isinstance(node.target, ast.Name):
            raise TranslationError("else after a loop, or several names in its head, are not known")
        target, counter = node.target, self._temporary()
        if isinstance(node.iter, ast.Call) and self._is_range(node.iter.func):
            start, stop, step = self._range(node.iter)
            head, item = (
                f"let {counter} = {start.code}; {counter} < {stop.code}; {counter} += {step}",
                Value(counter, INT),
            )
            # Python evaluates the end once.
            before = [] if stop.constant is not None else [f"const {counter}e = {stop.code};"]
            head = head if not before else head.replace(f"< {stop.code};", f"< {counter}e;")
        else:
            items = self._expressions.value(node.iter)
            if not isinstance(items.kind, Tuple):
                raise TranslationError("a loop is known over range and over tuples")
            before, at = [f"const {counter}s = {items.code};"], Value(counter, INT)
            head = f"let {counter} = 0; {counter} < {len(items.kind.items)}; {counter} += 1"
            item = arrays.element_of_tuple(Value(f"{counter}s", items.kind), at)

        def inside() -> list[str]:
            lines = self._assigned(target, item)
            return [f"for ({head}) {{", *_indented([*lines, *self._block(node.body)]), "}"]

        return [*before, *self._loop(inside)]

    def _is_range(self, node: ast.expr) -> bool:
        kind = self._expressions.value(node).kind
        return isinstance(kind, Known) and kind.value is range

    def _range(self, node: ast.Call) -> tuple[Value, Value, int]:
        ends = [as_number(self._expressions.value(argument)) for argument in node.args]
        if any(end.kind != INT for end in ends):
            raise TranslationError("range is known for whole numbers")
        zero = Value("0", INT, 0)
        step = ends[2].constant if len(ends) == 3 else 1
        if step is None or step <= 0:
            raise TranslationError("range is known with a constant step above zero")
        return (ends[0] if len(ends) > 1 else zero), ends[min(len(ends), 2) - 1], int(step)

    def _loop(self, inside: Callable[[], list[str]], forever: bool = False) -> list[str]:
        """The lines of a loop, whose names may be of another kind at its second turn: until they stay the same."""
        while True:
            before = dict(self._expressions.names)
            self._exits.append([])
            returns = len(self._returns)
            lines = inside()
            ends = [self._expressions.names, *self._exits.pop()]
            turned = before
            for names in ends:
                turned = _merged(turned, names)
            self._expressions.names = turned
            if {name: value.kind for name, value in turned.items() if name in before} == {
                name: value.kind for name, value in before.items()
            }:
                break
            self._expressions.names = {name: turned[name] for name in before}
            del self._returns[returns:]
        return lines

    # -- assignments --------------------------------------------------------------------------------------------------

    def _on_assign(self, node: ast.Assign) -> list[str]:
        if len(node.targets) == 1 and isinstance(node.targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple):
            return self._side_by_side(node.targets[0], node.value)
        value = self._expressions.value(node.value)
        lines: list[str] = []
        if len(node.targets) > 1 or isinstance(node.targets[0], ast.Tuple):
            name = self._temporary()
            lines, value = [f"const {name} = {value.code};"], Value(name, value.kind, value.constant)
        for target in node.targets:
            lines += self._assigned(target, value)
        return self._scoped(lines)

    def _side_by_side(self, target: ast.Tuple, source: ast.Tuple) -> list[str]:
        """`a, b = x, y`: all values first."""
        if len(target.elts) != len(source.elts):
            raise TranslationError(f"{len(source.elts)} values for {len(target.elts)} names")
        values, lines = [self._expressions.value(item) for item in source.elts], []
        for k, value in enumerate(values):
            if value.constant is None and not isinstance(value.kind, Known):
                name = self._temporary()
                lines.append(f"const {name} = {value.code};")
                values[k] = Value(name, value.kind)
        for item, value in zip(target.elts, values, strict=True):
            lines += self._assigned(item, value)
        return self._scoped(lines)

    def _scoped(self, lines: list[str]) -> list[str]:
        return lines if len(lines) == 1 else ["{", *_indented(lines), "}"]

    def _on_augassign(self, node: ast.AugAssign) -> list[str]:
        value = binary(node.op, self._expressions.value(node.target), self._expressions.value(node.value))
        return self._assigned(node.target, value)

    def _assigned(self, target: ast.expr, value: Value) -> list[str]:
        if isinstance(target, ast.Name):
            return self._named(target.id, value)
        if isinstance(target, ast.Tuple):
            if not isinstance(value.kind, Tuple) or len(value.kind.items) != len(target.elts):
                raise TranslationError(f"{described(value.kind)} cannot be spread over {len(target.elts)} names")
            pairs = zip(target.elts, value.kind.items, strict=True)
            return [
                line
                for k, (t, kind) in enumerate(pairs)
                for line in self._assigned(t, Value(f"{value.code}[{k}]", kind))
            ]
        if isinstance(target, ast.Attribute):
            field = self._expressions.value(target)
            base = self._expressions.value(target.value)
            if not isinstance(base.kind, Record):
                raise TranslationError(f"a field of {described(base.kind)} cannot be assigned")
            return [f"{field.code} = {stored(value, field.kind)};"]
        if isinstance(target, ast.Subscript):
            return [self._element(target, value)]
        raise TranslationError(f"{type(target).__name__} as a target is not known")

    def _element(self, target: ast.Subscript, value: Value) -> str:
        base, (indices, slices) = self._expressions.value(target.value), self._expressions.indices(target)
        if not isinstance(base.kind, Array) or not arrays.is_of_numbers(base.kind):
            raise TranslationError(f"an element of {described(base.kind)} cannot be assigned")
        kind = of_element(base.kind.dtype)
        if slices:
            view, part = arrays.view(base, indices, slices)
            filling = stored(value, kind)
            ends = [] if part == arrays.Slice() else arrays.bounds(view, part)
            return f"{view.code}.fill({', '.join([filling, *ends])});"
        if len(indices) != len(base.kind.shape):
            raise TranslationError("an array cannot be assigned whole: assign its elements")
        return f"{base.code}[{arrays.offset(base, indices)}] = {stored(value, kind)};"

    def _named(self, name: str, value: Value) -> list[str]:
        names = self._expressions.names
        if isinstance(value.kind, Known):
            raise TranslationError(f"a function or type as the value of {name!r} is not known")
        if name == "_":
            return []
        old = names.get(name)
        code = old.code if old else _safe(name)
        if old and joined(old.kind, value.kind) is None:
            code = f"{_safe(name)}${len(self._declared)}"  # from here on another variable
        self._declared.append(code)
        # Its value is not followed, its kind is.
        names[name] = Value(code, value.kind)
        return [f"{code} = {value.code};"]

    def _temporary(self) -> str:
        self._temporaries += 1
        return f"$t{self._temporaries}"


def _safe(name: str) -> str:
    """A name of Python as one of JavaScript."""
    return f"{name}$" if name in RESERVED else name


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _merged(one: Names, two: Names) -> Names:
    """Names after either of two ways; a way that ends has none."""
    if not one or not two:
        return dict(one or two)
    found: Names = {}
    for name in {**one, **two}:
        if name not in one or name not in two:
            found[name] = one.get(name) or two[name]
            continue
        kind = joined(one[name].kind, two[name].kind)
        if kind is None or one[name].code != two[name].code:
            kind = Lost(f"{described(one[name].kind)} or {described(two[name].kind)}")
        found[name] = Value(one[name].code, kind)
    return found
