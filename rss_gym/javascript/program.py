"""A program of JavaScript: translated functions, what they call, and the constants that they read."""

from __future__ import annotations

import ast
import inspect
import textwrap
import types
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.javascript.kinds import Kind, TranslationError
from rss_gym.javascript.statements import Statements
from rss_gym.javascript.values import literal

RUNTIME = Path(__file__).with_name("runtime.js")
_Key = tuple[types.FunctionType, tuple[Kind, ...]]


@dataclass
class _Translation:
    """One function for arguments of given kinds."""

    name: str
    code: str = ""
    returned: Kind | None = None  # None while it is being translated
    calls: list[_Key] = field(default_factory=list)


class Program:
    """Translates functions and all that they call, each once for arguments of the same kinds."""

    def __init__(self) -> None:
        self._functions: dict[_Key, _Translation] = {}
        self._constants: dict[int, tuple[str, np.ndarray]] = {}
        self._roots: list[_Key] = []

    def add(self, function: Any, kinds: Sequence[Kind]) -> str:
        """Translate a function that the page calls.

        Parameters
        ----------
        function : callable
            A kernel, or a plain function.
        kinds : sequence of Kind
            The kinds of its arguments.

        Returns
        -------
        str
            Its name in JavaScript.

        Raises
        ------
        TranslationError
            For what the translator does not know.
        """
        key = getattr(function, "py_func", function), tuple(kinds)
        self._translated(*key)
        self._roots.append(key)
        return self._functions[key].name

    @property
    def code(self) -> str:
        """Runtime, constants and functions; each function follows those that it calls."""
        parts = [RUNTIME.read_text(encoding="utf-8")]
        functions: dict[_Key, None] = {}
        for key in self._roots:
            self._collect(key, functions)
        translated = [f"function {self._functions[key].name}{self._functions[key].code}\n" for key in functions]
        parts += [
            f"const {name} = {literal(value)};\n"
            for name, value in self._constants.values()
            if any(name in text for text in translated)
        ]
        return "".join(parts + translated)

    def _collect(self, key: _Key, found: dict[_Key, None]) -> None:
        if key not in found:
            for called in self._functions[key].calls:
                self._collect(called, found)
            found[key] = None

    def _translated(self, function: types.FunctionType, kinds: tuple[Kind, ...]) -> _Translation:
        key = function, kinds
        if key not in self._functions:
            translation = self._functions[key] = _Translation(self._free_name(function))

            def called(other: types.FunctionType, given: list[Kind]) -> tuple[str, Kind]:
                found = self._translated(other, tuple(given))
                if found.returned is None:
                    raise TranslationError(f"{other.__name__!r} calls itself, which is not known")
                translation.calls.append((other, tuple(given)))
                return found.name, found.returned

            statements = Statements(function, self._constant, called)
            translation.code = statements.body(parsed(function), kinds)
            translation.returned = statements.returned
        return self._functions[key]

    def _free_name(self, function: types.FunctionType) -> str:
        stem = f"{function.__module__.rpartition('.')[2]}_{function.__name__}"
        taken = {translation.name for translation in self._functions.values()}
        return next(name for n in range(len(taken) + 1) if (name := f"{stem}${n}" if n else stem) not in taken)

    def _constant(self, value: np.ndarray) -> str:
        if id(value) not in self._constants:
            self._constants[id(value)] = f"$c{len(self._constants)}", value
        return self._constants[id(value)][0]


def parsed(function: types.FunctionType) -> ast.FunctionDef:
    """The syntax tree of a function, with the line numbers of its file."""
    try:
        lines, first = inspect.getsourcelines(function)
    except (OSError, TypeError) as error:
        raise TranslationError(f"the source of {function.__name__!r} is not known") from error
    tree = ast.parse(textwrap.dedent("".join(lines)))
    ast.increment_lineno(tree, first - 1)
    node = tree.body[0]
    if not isinstance(node, ast.FunctionDef):
        raise TranslationError(f"{function.__name__!r} is no function by def")
    return node
