"""The cache of compiled kernels on disk: a folder that is ours, files that check themselves, one compilation a machine.

Compiled code is read by unpickling, which can run code. So a folder or file that belongs to another user (root
excepted) is not read, and every file begins with the SHA-256 of the rest: a file that is cut short or altered counts as
missing. Nothing here is ever fatal: what cannot be read is compiled, what cannot be written is not kept, and either is
said once.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import stat
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator

from rss_gym.locking import free, take

LOCK = "compiling.lock"
WAIT_S = 300.0  # for another process that compiles; then both compile
_POLL_S = 0.1
_said = False


def say(reason: str) -> None:
    """Say once per process, on standard error, why kernels are compiled that should be at hand."""
    global _said
    if not _said:
        _said = True
        tell(f"{reason}; kernels are compiled where they are missing, which takes about 20 s")


def tell(line: str) -> None:
    """Print to standard error, if that can be written."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        print(f"rss_gym: {line}", file=sys.stderr, flush=True)


# -- the folder -------------------------------------------------------------------------------------------------------


def bases() -> Iterator[Path]:
    """Folders in which caches may lie, best first."""
    home = Path(os.path.expanduser("~")) if os.environ.get("HOME") != "" else Path()
    if os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(os.environ["NUMBA_CACHE_DIR"]).absolute()
    elif sys.platform == "win32":
        yield Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    else:
        yield Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    # One folder per user: the temporary folder is shared.
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "")
    yield _temporary() / f"cache-{user}"


def _temporary() -> Path:
    """The folder for temporary files; a relative path if there is none that can be written."""
    try:
        return Path(tempfile.gettempdir()).absolute()
    except OSError:
        return Path()


def find(tail: Path) -> Path | None:
    """The first folder `base / tail` that can be used, made if need be; None if there is none."""
    reasons = []
    for base in bases():
        try:
            if base.is_absolute():  # without a home, `~` would be a folder of that name
                return _prepared(base, tail)
        except OSError as error:
            reasons.append(f"{str(error.filename or base)!r}: {error.strerror or error}")
    say("no folder for compiled kernels can be used" + f" ({'; '.join(reasons)})" * bool(reasons))
    return None


def _prepared(base: Path, tail: Path) -> Path:
    """`base / tail`, ours and fit for reading at least; else an OSError."""
    base.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder = base
    levels = [base] if base.parent == _temporary() else []
    for part in tail.parts:
        folder = folder / part
        if not folder.is_dir():
            folder.mkdir(mode=0o700, exist_ok=True)
        levels.append(folder)
    for level in levels:
        found = level.lstat() if level == base else level.stat()
        if not stat.S_ISDIR(found.st_mode):
            raise NotADirectoryError(0, "is not a folder", str(level))
        if not is_ours(found):
            raise PermissionError(0, "belongs to another user", str(level))
        if os.name == "posix" and found.st_mode & stat.S_IWOTH:
            raise PermissionError(0, "can be written by every user", str(level))
    if not any(folder.glob("**/*.nbi")):  # a full one may be read-only, as in an image of a container
        with tempfile.TemporaryFile(dir=folder):
            pass
    return folder


def is_ours(found: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user or to root."""
    return not hasattr(os, "geteuid") or found.st_uid in (os.geteuid(), 0)


# -- one compilation at a time ----------------------------------------------------------------------------------------


class Turn:
    """The lock of a cache folder: held from the first kernel that is missing to the end of its compilation.

    Parameters
    ----------
    folder : Path
        The folder of the cache.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / LOCK
        self._guard = threading.Lock()
        self._depth = 0
        self._descriptor: int | None = None

    @contextlib.contextmanager
    def scope(self) -> Iterator[None]:
        """What is taken within the outermost scope is given back at its end."""
        with self._guard:
            self._depth += 1
        try:
            yield
        finally:
            with self._guard:
                self._depth -= 1
                if self._depth == 0 and self._descriptor is not None:
                    with contextlib.suppress(OSError):
                        free(self._descriptor)
                    os.close(self._descriptor)
                    self._descriptor = None

    def take(self) -> bool:
        """Wait for the lock; True if it was taken just now, False if it is held already or cannot be had."""
        if self._descriptor is not None or self._depth == 0:
            return False
        try:
            descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError:  # a folder that cannot be written
            return False
        try:
            end, told = time.monotonic() + WAIT_S, time.monotonic() + 1.0
            while not take(descriptor):
                if time.monotonic() > end:
                    raise TimeoutError
                if time.monotonic() > told:
                    told = end
                    tell("waiting for another process that compiles the kernels")
                time.sleep(_POLL_S)
        except OSError:  # no locks on this file system, or no patience left
            os.close(descriptor)
            return False
        self._descriptor = descriptor
        return True


# -- what Numba asks for ----------------------------------------------------------------------------------------------


class _Locator(_CacheLocator):
    """Where a function's compiled code lies. The folder's name stands for all sources, so nothing else is compared."""

    def __init__(self, function: Any, folder: Path) -> None:
        self._py_file, self._line = function.__code__.co_filename, function.__code__.co_firstlineno
        package = function.__module__.rpartition(".")[0]  # modules of one name lie in different packages
        self._folder = folder / (package or "_")

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return ""

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Impl(CompileResultCacheImpl):
    def __init__(self, function: Any, folder: Path) -> None:
        self._lineno, self._locator = function.__code__.co_firstlineno, _Locator(function, folder)
        name = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}"
        self._filename_base = self.get_filename_base(name, getattr(sys, "abiflags", ""))


class _File(IndexDataCacheFile):
    """Numba's index and data files, each with the digest of its content in front."""

    def _load_index(self) -> dict[Any, str]:
        return self._read(self._index_path) or {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, overloads)

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _write(self, path: str, content: Any) -> None:
        pickled = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(pickled).digest() + pickled)

    def _read(self, path: str) -> Any:
        try:
            with open(path, "rb") as file:
                if not is_ours(os.fstat(file.fileno())):
                    raise PermissionError(0, "belongs to another user", path)
                digest, pickled = file.read(32), file.read()
        except FileNotFoundError:
            return None
        if hashlib.sha256(pickled).digest() != digest:
            say(f"the file of compiled kernels {path!r} is damaged")
            return None
        return pickle.loads(pickled)


class KernelCache(FunctionCache):
    """Numba's cache of one function, which never fails.

    Parameters
    ----------
    function : function
        Python's own.
    folder : Path
        As `find` returns it.
    turn : Turn
        The turn that processes take to write into the folder.
    """

    def __init__(self, function: Any, folder: Path, turn: Turn) -> None:
        self._name, self._py_func, self._turn = repr(function), function, turn
        self._impl = _Impl(function, folder)
        self._cache_path = self._impl.locator.get_cache_path()
        self._cache_file = _File(self._cache_path, self._impl.filename_base, self._impl.locator.get_source_stamp())
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled code, or None; then this process has the turn to compile it, if there are turns."""
        found = self._load(sig, target_context)
        if found is None and self._turn.take():
            found = self._load(sig, target_context)  # another process may have compiled it meanwhile
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep compiled code, if it can be kept."""
        try:
            super().save_overload(sig, data)
        except Exception as error:
            say(f"compiled kernels cannot be kept in {self._cache_path!r}: {_reason(error)}")

    def _load(self, sig: Any, target_context: Any) -> Any:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                return super().load_overload(sig, target_context)
        except Exception as error:  # whatever unpickling raises
            say(f"compiled kernels cannot be read from {self._cache_path!r}: {_reason(error)}")
            return None


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__)[:200]
