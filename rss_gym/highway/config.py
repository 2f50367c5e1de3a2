"""Checks configurations of highway-env, which takes any key and leaves those it does not know unread."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping
from typing import Any

from rss_gym.params import ParamsError, suggestion

ACTIONS = "highway_env.envs.common.action"


def check(given: Any, known: Mapping[str, Any]) -> None:
    """Refuse keys that highway-env would not read.

    Parameters
    ----------
    given : dict
        What is to be changed.
    known : dict
        The environment's configuration.

    Raises
    ------
    ParamsError
        Naming the key and the nearest known one.
    """
    if not isinstance(given, Mapping):
        raise ParamsError(f"config must be a dict, got {given!r}")
    for key, value in given.items():
        if key not in known:
            raise ParamsError(f"config has no key {key!r}{suggestion(str(key), known)}")
        if key == "observation":
            raise ParamsError("config['observation'] has no effect here: the observation is that of the radio")
        if key == "action":
            _check_action(value)


def _check_action(given: Any) -> None:
    """A table whose `type` names a class; the other keys must be arguments of its constructors."""
    if not isinstance(given, Mapping) or "type" not in given:
        raise ParamsError(f"config['action'] must be a dict with 'type', got {given!r}")
    module = importlib.import_module(ACTIONS)
    kinds = {name: kind for name, kind in vars(module).items() if inspect.isclass(kind) and name.endswith("Action")}
    kind = kinds.get(given["type"])
    if kind is None:
        raise ParamsError(
            f"config['action'] has an unknown type {given['type']!r}{suggestion(str(given['type']), kinds)}"
        )
    arguments = {"type", *(name for base in kind.__mro__ for name in _arguments(base))} - {"self", "env", "kwargs"}
    for key in given:
        if key not in arguments:
            raise ParamsError(f"config['action'] has no key {key!r}{suggestion(str(key), arguments)}")


def _arguments(kind: type) -> list[str]:
    """Names that a class's own constructor takes."""
    return list(inspect.signature(vars(kind)["__init__"]).parameters) if "__init__" in vars(kind) else []
