"""The one decorator that compiles the package's numerical kernels.

Numba's own on-disk cache is keyed by the source of the decorated function, so
it keeps stale machine code when a *callee* in another file is edited.  Here the
cache folder is named by a digest of every source file of the package instead.
"""

import functools
import hashlib
import os
import sys
import tempfile
from pathlib import Path

import numba

__all__ = ["announce", "cache_dir", "inner", "kernel"]

# Parts of this package that hold no kernel and that none calls (tested): an edit there need not compile anything.
_WITHOUT_KERNELS = {
    (name,)
    for name in (
        *("calibration", "eval", "train", "render", "pages", "commands", "testing"),
        *("arguments.py", "cli.py", "errors.py", "extend.py", "files.py", "listing.py", "registry.py"),
    )
}
# The entry point for C is of no use here and takes time to compile.
_OPTIONS = {"cache": True, "fastmath": False, "error_model": "numpy", "no_cfunc_wrapper": True}


def _candidates():
    """Yield folders that may hold the cache, best first."""
    home = Path(os.path.expanduser("~"))
    if os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(os.environ["NUMBA_CACHE_DIR"])
    elif sys.platform == "win32":
        yield Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    else:
        yield Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    # One folder per user: the temporary folder is shared, and a cache is code.
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "")
    yield Path(tempfile.gettempdir()) / f"cache-{user}"


def _writable(folder):
    """Create ``folder`` if needed and say whether files can be made in it."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _digest(root):
    """Hash the Numba version and every ``*.py`` file below ``root`` (or the file) that a kernel may call or read."""
    state = hashlib.sha256(numba.__version__.encode())
    # Path.rglob does not enter linked folders, and a checkout has some.
    walk = os.walk(root, followlinks=True) if root.is_dir() else []
    files = [Path(here) / name for here, _, names in walk for name in names]
    for file in sorted(file for file in files or [root] if file.suffix == ".py"):
        if file.relative_to(root).parts[:1] in _WITHOUT_KERNELS:
            continue
        source = file.read_bytes()
        # Lengths keep the boundaries between names and contents unambiguous.
        name = file.relative_to(root.parent).as_posix().encode()
        state.update(b"%d %d " % (len(name), len(source)) + name + source)
    return state.hexdigest()[:24]


@functools.cache
def cache_dir(root):
    """Folder for the compiled code of the package at ``root``.

    Parameters
    ----------
    root : pathlib.Path
        Folder of the package, or the file of a single-module distribution.

    Returns
    -------
    str
        ``<user cache>/<package name>/<digest>``.  The user cache is
        ``$NUMBA_CACHE_DIR``, else ``$XDG_CACHE_HOME``, else ``~/.cache``
        (``%LOCALAPPDATA%`` on Windows); if that cannot be written, a per-user
        folder in the temporary directory.  The folder is created.  The
        result is computed once per process and root.
    """
    tail = Path(root.stem) / _digest(root)
    folders = [base / tail for base in _candidates()]
    return str(next(filter(_writable, folders), folders[-1]))


def _root_of(function):
    """Path of the top-level package (or lone file) that defines ``function``."""
    top = sys.modules.get(function.__module__.partition(".")[0])
    for folder in getattr(top, "__path__", ()):
        return Path(folder).resolve()
    return Path(function.__code__.co_filename).resolve()


@functools.cache
def announce(root):
    """Say once per process, on standard error, why the first call takes long, if nothing is compiled yet."""
    if not any(Path(cache_dir(root)).rglob("*.nbi")):
        print("rss_gym: compiling its kernels for this machine, once per version (about 20 s)", file=sys.stderr)


def kernel(function=None, **options):
    """Compile a function with Numba under the package's numerical rules.

    ``fastmath`` is off (no reordering, no fused multiply-add), division
    follows IEEE 754, and machine code is kept in :func:`cache_dir`.

    Parameters
    ----------
    function : callable, optional
        The function, when used as ``@kernel``.
    **options
        Further options of :func:`numba.njit`, when used as
        ``@kernel(inline="always")``.

    Returns
    -------
    callable
        The Numba dispatcher (or the plain function if ``NUMBA_DISABLE_JIT=1``).
    """
    if function is None:
        return functools.partial(kernel, **options)
    # Numba reads the setting while it decorates; other users of Numba in the
    # process must not notice.
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_dir(_root_of(function))
    try:
        return numba.njit(**{**_OPTIONS, **options})(function)
    finally:
        numba.config.CACHE_DIR = before


def inner(function=None, **options):
    """Compile a function that only other kernels call.

    It is not kept on disk and has no entry point for Python, which makes compiling it cheaper; calling it from Python
    ends the process. A small kernel that tests call too is best a ``kernel(inline="always")``. What is called for every
    row where arrays are at hand must be ``forceinline=True``, or Numba counts references there at every call.
    """
    return kernel(function, cache=False, no_cpython_wrapper=True, **options)
