"""Checks configurations of highway-env, which takes any key and leaves those it does not know unread."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping
from typing import Any

from rss_gym.params import ParamsError, suggestion

TYPED = {"action": "highway_env.envs.common.action", "observation": "highway_env.envs.common.observation"}


def check(given: Any, known: Mapping[str, Any], where: str = "config") -> None:
    """Refuse keys that highway-env would not read, in tables of tables too.

    Parameters
    ----------
    given : dict
        What is to be changed.
    known : dict
        The environment's configuration.
    where : str
        For the sentence.

    Raises
    ------
    ParamsError
        Naming the key and the nearest known one.
    """
    if not isinstance(given, Mapping):
        raise ParamsError(f"{where} must be a dict, got {given!r}")
    for key, value in given.items():
        if key not in known:
            raise ParamsError(f"{where} has no key {key!r}{suggestion(str(key), known)}")
        if isinstance(known[key], Mapping):
            _check_typed(value, known[key], f"{where}[{key!r}]", TYPED.get(key))


def _check_typed(given: Any, known: Mapping[str, Any], where: str, module: str | None) -> None:
    """A table whose keys are the arguments of the class that its `type` names."""
    if not isinstance(given, Mapping):
        raise ParamsError(f"{where} must be a dict, got {given!r}")
    if module is None:
        return check(given, known, where)
    kinds = importlib.import_module(module)
    kind = given.get("type", known.get("type"))
    found = getattr(kinds, kind, None) if isinstance(kind, str) else None
    if not inspect.isclass(found):
        classes = [name for name, item in inspect.getmembers(kinds, inspect.isclass) if item.__module__ == module]
        raise ParamsError(f"{where} has type {kind!r}, which highway-env does not know{suggestion(str(kind), classes)}")
    arguments = {"type", *(name for base in found.__mro__ for name in _arguments(base))} - {"self", "env", "kwargs"}
    for key in given:
        if key not in arguments:
            raise ParamsError(f"{where} has no key {key!r}{suggestion(str(key), arguments)}")


def _arguments(kind: type) -> list[str]:
    """Names that a class's own constructor takes."""
    return list(inspect.signature(vars(kind)["__init__"]).parameters) if "__init__" in vars(kind) else []
