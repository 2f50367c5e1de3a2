"""Registries: named parts of the package, open to users and to their plug-ins.

A registry is a mapping in a module of its layer, with a Protocol or a dataclass beside it that says what a part is.
`of(kind)` finds it without importing the others. A package that wants its parts to be there in every process, in worker
processes and on the command line too, names a function or a module in the entry-point group `rss_gym.plugins`; it is
called or imported when a registry is first read.
"""

from __future__ import annotations

import functools
import importlib
import pickle
import re
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from rss_gym.errors import ParamsError, suggestion

Part = TypeVar("Part")

GROUP = "rss_gym.plugins"
# Kind -> module and attribute of its registry.
HOMES: dict[str, tuple[str, str]] = {
    "channel": ("rss_gym.params", "CHANNELS"),
    "estimator": ("rss_gym.ranging", "ESTIMATORS"),
    "tracker": ("rss_gym.tracking", "TRACKERS"),
    "family": ("rss_gym.encounters", "FAMILIES"),
    "rule": ("rss_gym.baselines", "POLICIES"),
    "metric": ("rss_gym.eval.metrics", "METRICS"),
    "suite": ("rss_gym.eval.suites", "SUITES"),
}


class Registry(Mapping[str, Part], Generic[Part]):
    """Name -> part, in the order in which they were entered; the shipped ones come first.

    Parameters
    ----------
    kind : str
        What the parts are, for sentences; a key of `HOMES`.
    shipped : mapping
        The parts of this package.
    check : callable
        Raises `ParamsError` in one sentence for a name and a part that does not fit the registry.
    name : str
        Regular expression that names match.
    like : str
        A name that does, for the sentence about one that does not.
    """

    def __init__(
        self,
        kind: str,
        shipped: Mapping[str, Part],
        check: Callable[[str, Part], None],
        name: str = "[a-z][a-z0-9-]*",
        like: str = "my-part",
    ) -> None:
        self.kind, self.shipped = kind, tuple(shipped)
        self._check, self._name, self._like = check, re.compile(name), like
        self._parts = dict(shipped)
        self._sent = set[str]()  # names that other processes do not find by themselves

    def __getitem__(self, name: str) -> Part:
        load_plugins()
        return self._parts[name]

    def __iter__(self) -> Iterator[str]:
        load_plugins()
        return iter(self._parts)

    def __len__(self) -> int:
        load_plugins()
        return len(self._parts)

    def find(self, name: str) -> Part:
        """The part of that name.

        Raises
        ------
        ParamsError
            For an unknown name, with the nearest known one.
        """
        if not isinstance(name, str) or name not in self:
            raise ParamsError(f"{self.kind} {name!r} is unknown{suggestion(str(name), self)}")
        return self[name]

    def register(self, name: str, part: Part) -> None:
        """Enter a part.

        Raises
        ------
        ParamsError
            For a name that is no name or is taken, or a part that is none.
        """
        if not isinstance(name, str) or self._name.fullmatch(name) is None:
            raise ParamsError(f"{self.kind} name {name!r} must look like {self._like!r}")
        if not _plugins.running:
            load_plugins()
        if name in self._parts:
            raise ParamsError(f"{self.kind} {name!r} is registered already; give the new one another name")
        self._check(name, part)
        self._parts[name] = part
        if not _plugins.running:
            self._sent.add(name)

    def remove(self, name: str) -> None:
        """Take out a part that was registered; those of this package stay."""
        if name in self.shipped or name not in self._parts:
            raise ParamsError(f"{self.kind} {name!r} was not registered by `rss_gym.register_{self.kind}`")
        del self._parts[name]
        self._sent.discard(name)

    def added(self) -> list[tuple[str, Part]]:
        """The parts, with their names, that another process does not find by itself."""
        return [(name, part) for name, part in self._parts.items() if name in self._sent]


def of(kind: str) -> Registry[Any]:
    """The registry of a kind; imports its layer.

    Raises
    ------
    ParamsError
        For an unknown kind.
    """
    if kind not in HOMES:
        raise ParamsError(f"registry {kind!r} is unknown{suggestion(kind, HOMES)}")
    module, attribute = HOMES[kind]
    registry: Registry[Any] = getattr(importlib.import_module(module), attribute)
    return registry


def added() -> bytes:
    """What a worker process is sent to have the parts registered here; empty if there are none.

    Raises
    ------
    ParamsError
        If a part cannot be pickled.
    """
    parts = []
    for kind, (module, _) in HOMES.items():
        if module not in sys.modules:  # nothing was registered there
            continue
        for name, part in of(kind).added():
            try:
                pickle.dumps(part)
            except Exception as error:  # __reduce__ may raise anything
                raise ParamsError(
                    f"{kind} {name!r} cannot be sent to worker processes ({_first_line(error)}); "
                    "define it in a module, or use workers=1"
                ) from error
            parts.append((kind, name, part))
    return pickle.dumps(parts) if parts else b""


@functools.cache
def restore(sent: bytes) -> None:
    """In a worker process: register what `added` sent, unless it is there already."""
    for kind, name, part in pickle.loads(sent) if sent else ():
        registry = of(kind)
        if name not in registry:
            registry.register(name, part)


class _Plugins:
    """Whether the plug-ins of the environment have been loaded, and what went wrong."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.done = self.running = False
        self.failure = ""


_plugins = _Plugins()


def load_plugins() -> None:
    """Call or import every plug-in of the environment, once; while a module of this package is imported, later.

    Raises
    ------
    ParamsError
        If one fails, here and at every later call: which, of which package, and why.
    """
    if not _plugins.done and not _plugins.running and not _is_importing():
        with _plugins.lock:
            if not _plugins.done and not _plugins.running:
                _plugins.running = True
                try:
                    _plugins.failure = next(filter(None, map(_load, entry_points(group=GROUP))), "")
                finally:
                    _plugins.running, _plugins.done = False, True
    if _plugins.failure:
        raise ParamsError(_plugins.failure)


def _load(point: EntryPoint) -> str:
    """Load one plug-in; returns what went wrong."""
    try:
        found = point.load()
        if callable(found):
            found()
    except Exception as error:
        package = point.dist.name if point.dist is not None else "an unknown package"
        what = f"plug-in {point.name!r} = {point.value!r} of {package}"
        return f"{what} failed ({_first_line(error)}); mend it or uninstall it"
    return ""


def _is_importing() -> bool:
    """Whether a module of this package is half imported, so that a plug-in could not use it."""
    modules = [module for name, module in list(sys.modules.items()) if name.partition(".")[0] == "rss_gym"]
    return any(getattr(getattr(module, "__spec__", None), "_initializing", False) for module in modules)


def _first_line(error: Exception) -> str:
    return f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"
