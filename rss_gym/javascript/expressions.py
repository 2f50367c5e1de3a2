"""Expressions of a kernel as expressions of JavaScript."""

from __future__ import annotations

import ast
import builtins
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from rss_gym.javascript import arrays
from rss_gym.javascript.arithmetic import binary, compared, truth, unary
from rss_gym.javascript.calls import FUNCTIONS, is_known, reinterpreted
from rss_gym.javascript.kinds import (
    BOOL,
    Array,
    Kind,
    Known,
    Lost,
    Named,
    Record,
    TranslationError,
    Tuple,
    Value,
    described,
    joined,
    of_element,
)
from rss_gym.javascript.values import kind_of, literal

Constant = Callable[[Any], str]
Function = Callable[[types.FunctionType, list[Kind]], tuple[str, Kind]]


class Expressions:
    """Translates expressions that find names in an environment and in the globals of a function.

    Parameters
    ----------
    function : function
        Whose globals and closure hold what is no local name.
    constant : callable
        Array -> name of a constant that holds it.
    translated : callable
        Function and kinds of its arguments -> its name in JavaScript and the kind that it returns.

    Attributes
    ----------
    names : dict
        Local names and what they are.
    """

    def __init__(self, function: types.FunctionType, constant: Constant, translated: Function) -> None:
        self.names: dict[str, Value] = {}
        self._globals, self._constant, self._translated = _found_by(function), constant, translated

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        method = getattr(self, f"_on_{type(node).__name__.lower()}", None)
        if method is None:
            raise TranslationError(f"{type(node).__name__} is not known")
        found: Value = method(node)
        return found

    def condition(self, node: ast.expr) -> str:
        """Code of an expression as a condition."""
        return truth(self.value(node))

    def _constant_of(self, value: Any) -> Value:
        if isinstance(value, (types.ModuleType, type)) or callable(value):
            return Value("", Known(value))
        if isinstance(value, np.ndarray):
            return Value(self._constant(value), kind_of(value))
        simple = value if isinstance(value, (int, float)) and not isinstance(value, bool) else None
        return Value(literal(value), kind_of(value), simple)

    def _on_constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, (bool, int, float)):
            raise TranslationError(f"the constant {node.value!r} is not known")
        return self._constant_of(node.value)

    def _on_name(self, node: ast.Name) -> Value:
        if node.id in self.names:
            value = self.names[node.id]
            if isinstance(value.kind, Lost):
                raise TranslationError(f"{node.id!r} is {value.kind.ways} here")
            return value
        if node.id not in self._globals:
            raise TranslationError(f"name {node.id!r} is not known")
        return self._constant_of(self._globals[node.id])

    def _on_binop(self, node: ast.BinOp) -> Value:
        return binary(node.op, self.value(node.left), self.value(node.right))

    def _on_unaryop(self, node: ast.UnaryOp) -> Value:
        return unary(node.op, self.value(node.operand))

    def _on_boolop(self, node: ast.BoolOp) -> Value:
        values = [self.value(part) for part in node.values]
        if any(value.kind != BOOL for value in values):
            raise TranslationError("and, or are known for conditions only")
        return Value(
            "(" + (" && " if isinstance(node.op, ast.And) else " || ").join(v.code for v in values) + ")", BOOL
        )

    def _on_compare(self, node: ast.Compare) -> Value:
        if len(node.ops) > 1 and not all(
            isinstance(middle, (ast.Name, ast.Constant)) for middle in node.comparators[:-1]
        ):
            raise TranslationError("a chain of comparisons is known with names and constants in its middle")
        values = [self.value(node.left), *map(self.value, node.comparators)]
        parts = [compared(op, a, b) for op, a, b in zip(node.ops, values, values[1:], strict=False)]
        return Value(parts[0] if len(parts) == 1 else f"({' && '.join(parts)})", BOOL)

    def _on_ifexp(self, node: ast.IfExp) -> Value:
        one, two = self.value(node.body), self.value(node.orelse)
        kind = joined(one.kind, two.kind)
        if kind is None:
            raise TranslationError(f"a value that is {described(one.kind)} or {described(two.kind)} is not known")
        return Value(f"({self.condition(node.test)} ? {one.code} : {two.code})", kind)

    def _on_tuple(self, node: ast.Tuple) -> Value:
        values = [self.value(item) for item in node.elts]
        return Value(f"[{', '.join(value.code for value in values)}]", Tuple(tuple(value.kind for value in values)))

    def _on_attribute(self, node: ast.Attribute) -> Value:
        base = self.value(node.value)
        if isinstance(base.kind, Known) and isinstance(base.kind.value, types.ModuleType):
            return self._constant_of(getattr(base.kind.value, node.attr))
        if isinstance(base.kind, Record) and node.attr in (base.kind.dtype.names or ()):
            return Value(f"{base.code}.{node.attr}", of_element(base.kind.dtype[node.attr]))
        if isinstance(base.kind, Named) and node.attr in dict(base.kind.fields):
            return Value(f"{base.code}.{node.attr}", dict(base.kind.fields)[node.attr])
        if isinstance(base.kind, Array) and node.attr == "size":
            return arrays.size(base)
        raise TranslationError(f"attribute {node.attr!r} of {described(base.kind)} is not known")

    def _on_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            axis = self.value(node.slice)
            if axis.constant is None or axis.constant < 0:
                raise TranslationError("shape is known with a constant axis")
            return arrays.length(self.value(node.value.value), int(axis.constant))
        base, (indices, slices) = self.value(node.value), self.indices(node)
        if isinstance(base.kind, Tuple) and len(indices) == 1 and not slices:
            return arrays.element_of_tuple(base, indices[0])
        if not isinstance(base.kind, Array):
            raise TranslationError(f"{described(base.kind)} has no elements")
        if slices:
            return arrays.sliced(*arrays.view(base, indices, slices))
        return arrays.element(base, indices)

    def indices(self, node: ast.Subscript) -> tuple[list[Value], list[arrays.Slice]]:
        """Leading indices and trailing slices."""
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        indices: list[Value] = []
        slices: list[arrays.Slice] = []
        for part in parts:
            if isinstance(part, ast.Slice):
                if part.step is not None:
                    raise TranslationError("slices with a step are not known")
                slices.append(
                    arrays.Slice(*(None if end is None else self.value(end) for end in (part.lower, part.upper)))
                )
            elif slices:
                raise TranslationError("an index after a slice is not known")
            else:
                indices.append(self.value(part))
        return indices, slices

    def _on_call(self, node: ast.Call) -> Value:
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            raise TranslationError("arguments by keyword or by star are not known")
        arguments = [self.value(argument) for argument in node.args]
        if isinstance(node.func, ast.Attribute) and node.func.attr == "view":
            return reinterpreted(self.value(node.func.value), _type_of(arguments))
        function = self.value(node.func).kind
        if not isinstance(function, Known):
            raise TranslationError("a call of what is no function is not known")
        if is_known(function.value):
            return FUNCTIONS[function.value](*arguments)
        source = getattr(function.value, "py_func", function.value)
        if not isinstance(source, types.FunctionType):
            raise TranslationError(f"function {getattr(source, '__name__', source)!r} is not known")
        name, kind = self._translated(source, [argument.kind for argument in arguments])
        return Value(f"{name}({', '.join(argument.code for argument in arguments)})", kind)


def _type_of(arguments: list[Value]) -> Any:
    if len(arguments) != 1 or not isinstance(arguments[0].kind, Known):
        raise TranslationError("view is known with one type")
    return arguments[0].kind.value


def _found_by(function: types.FunctionType) -> dict[str, Any]:
    """What a function finds by names that are not its own."""
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    return {**vars(builtins), **function.__globals__, **{name: cell.cell_contents for name, cell in cells}}
