"""Policies given as code, `module:attribute` or `file.py:attribute`: an object, a function or a plain class."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from rss_gym.params import Params, ParamsError

TAKES = ("params", "world")  # names of an argument that is given the world's parameters


def imported(spec: str, params: Params) -> Any:
    """The policy that a specification names.

    Parameters
    ----------
    spec : str
        `module:attribute` or `path/to/file.py:attribute`. What has a `predict` is the policy; a class or function is
        called: with the parameters of the world if it needs an argument or has one of the names in `TAKES`, else
        without.
    params : Params
        The world's.

    Raises
    ------
    ParamsError
        If there is no such module, file or attribute, or the policy cannot be made.
    """
    module, _, attribute = spec.rpartition(":")
    try:
        found: Any = _file(module) if module.endswith(".py") else importlib.import_module(module)
        for name in attribute.split("."):
            found = getattr(found, name)
    except (ImportError, AttributeError, OSError, TypeError, ValueError) as error:
        raise ParamsError(
            f"policy {spec!r} is neither a known name nor module:attribute or file.py:attribute ({error})"
        ) from error
    if hasattr(found, "predict") and not isinstance(found, type):
        return found
    if not callable(found):
        raise ParamsError(
            f"policy {spec!r} is neither an object with `predict` nor what makes one, got {found!r}"[:300]
        )
    try:
        return found(params) if _takes_params(found) else found()
    except Exception as error:
        raise ParamsError(f"policy {spec!r} failed to be made: {error}") from error


def _takes_params(call: Any) -> bool:
    """Whether it is to be given the world's parameters."""
    try:
        given = list(inspect.signature(call).parameters.values())
    except (TypeError, ValueError):  # builtins
        return False
    first = next((p for p in given if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD, p.VAR_POSITIONAL)), None)
    if first is None or first.kind is first.VAR_POSITIONAL:
        return False
    return first.default is first.empty or first.name in TAKES


def _file(path: str) -> ModuleType:
    """The module of a file, once per process; its folder is searched for what it imports."""
    real = os.path.realpath(path)
    if not os.path.isfile(real):
        raise FileNotFoundError(f"there is no file {path!r}")
    name = f"policy_{Path(real).stem}_{hashlib.sha256(real.encode()).hexdigest()[:8]}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, real)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        folder = os.path.dirname(real)
        if folder not in sys.path:
            sys.path.append(folder)
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
