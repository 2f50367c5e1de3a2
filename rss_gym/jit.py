"""The one decorator that compiles the package's numerical kernels.

Numba's own on-disk cache is keyed by the place and time of the decorated function's file, so
it keeps stale machine code when a *callee* in another file is edited, and compiles anew what a
fresh checkout holds.  Here the cache folder is named by a digest of every source file of the
package instead.
"""

import functools
import hashlib
import os
import re
import sys
import types
from pathlib import Path

import numba

from rss_gym import kernel_cache
from rss_gym.errors import ParamsError

__all__ = [
    "announce",
    "cache_dir",
    "compiled",
    "digest_of",
    "guarded",
    "inner",
    "kernel",
    "parts_dir",
    "rebound",
    "rebound_kernel",
]

# Parts of this package that hold no kernel and that none calls (tested): an edit there need not compile anything.
_WITHOUT_KERNELS = {
    (name,)
    for name in (
        *("calibration", "commands", "eval", "fly", "javascript", "pages", "render", "testing", "train"),
        *("__main__.py", "arguments.py", "cli.py", "demo.py", "env.py", "errors.py", "extend.py", "files.py"),
        *(
            "listing.py",
            "meanings.py",
            "plain_files.py",
            "progress.py",
            "registry.py",
            "rows.py",
            "sb3.py",
            "schema.py",
        ),
        *("terminal.py", "vector.py", "warm.py"),
    )
}
# The entry point for C is of no use here and takes time to compile.
_OPTIONS = {"fastmath": False, "error_model": "numpy", "no_cfunc_wrapper": True}


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
    pathlib.Path or None
        ``<user cache>/<package name>/<digest>``.  The user cache is
        ``$NUMBA_CACHE_DIR``, else ``$XDG_CACHE_HOME``, else ``~/.cache``
        (``%LOCALAPPDATA%`` on Windows); if that cannot be used, a per-user
        folder in the temporary directory; None if that cannot be used either.
        The folder is created.  The result is computed once per process and root.
    """
    return kernel_cache.find(Path(root.stem) / _digest(root))


@functools.cache
def _turn(folder):
    return kernel_cache.Turn(folder)


def _root_of(function):
    """Path of the top-level package (or lone file) that defines ``function``."""
    top = sys.modules.get(function.__module__.partition(".")[0])
    for folder in getattr(top, "__path__", ()):
        return Path(folder).resolve()
    return Path(function.__code__.co_filename).resolve()


@functools.cache
def announce(root):
    """Say once per process, on standard error, why the first call takes long, if nothing is compiled yet.

    Raises
    ------
    ParamsError
        Where Numba is switched off: the state is kept in records, whose fields only compiled code reads as attributes.
    """
    if numba.config.DISABLE_JIT:
        raise ParamsError("NUMBA_DISABLE_JIT is set, and the world's kernels only run compiled: unset it")
    folder = cache_dir(root)
    if folder is None or not any(folder.rglob("*.nbi")):
        kernel_cache.tell("compiling its kernels for this machine, once per version (about 20 s)")


def kernel(function=None, *, cache=True, **options):
    """Compile a function with Numba under the package's numerical rules.

    ``fastmath`` is off (no reordering, no fused multiply-add), division
    follows IEEE 754, and machine code is kept in :func:`cache_dir`.

    Parameters
    ----------
    function : callable, optional
        The function, when used as ``@kernel``.
    cache : bool
        Keep the machine code on disk.
    **options
        Further options of :func:`numba.njit`, when used as
        ``@kernel(inline="always")``.

    Returns
    -------
    callable
        The Numba dispatcher (or the plain function if ``NUMBA_DISABLE_JIT=1``).
    """
    if function is None:
        return functools.partial(kernel, cache=cache, **options)
    dispatcher = numba.njit(**{**_OPTIONS, **options})(function)
    return _kept(dispatcher, function, cache_dir(_root_of(function)) if cache and dispatcher is not function else None)


def _kept(dispatcher, function, folder):
    """The dispatcher of a function, whose machine code is kept in a folder, if there is one."""
    if folder is not None:
        turn, compile_ = _turn(folder), dispatcher.compile

        def compile(signature):
            with turn.scope():
                return compile_(signature)

        dispatcher._cache, dispatcher.compile = kernel_cache.KernelCache(function, folder, turn), compile
    return dispatcher


def inner(function=None, **options):
    """Compile a function that only other kernels call.

    It is not kept on disk and has no entry point for Python, which makes compiling it cheaper; calling it from Python
    ends the process. A small kernel that tests call too is best a ``kernel(inline="always")``. What is called for every
    row where arrays are at hand must be ``forceinline=True``, or Numba counts references there at every call.
    """
    return kernel(function, cache=False, no_cpython_wrapper=True, **options)


# -- functions from outside the package -------------------------------------------------------------------------------


def compiled(function):
    """A function that kernels can call: as it is if Numba has compiled it, else compiled by the rules of `inner`."""
    if hasattr(function, "py_func"):
        return function
    return numba.njit(**_OPTIONS, no_cpython_wrapper=True)(function)


def rebound(function, **replaced):
    """A copy of an `inner` that finds other values by these names of its module, for other kernels to call."""
    return numba.njit(**_OPTIONS, no_cpython_wrapper=True)(_copied(function, replaced))


def rebound_kernel(function, folder, **replaced):
    """A copy of a kernel that finds other values by these names of its module.

    Parameters
    ----------
    function : callable
        What `kernel` returned.
    folder : Path or None
        Where its machine code is kept, see `parts_dir`.
    **replaced
        Name -> what the copy finds there.
    """
    copy = _copied(function, replaced)
    dispatcher = numba.njit(**_OPTIONS)(copy)
    return _kept(dispatcher, copy, folder if dispatcher is not copy else None)


def _copied(function, replaced):
    source = getattr(function, "py_func", function)
    names = {**source.__globals__, **replaced}
    return types.FunctionType(source.__code__, names, source.__name__, source.__defaults__, source.__closure__)


def guarded(function, what):
    """A kernel that calls functions from outside the package; one that Numba cannot compile raises `ParamsError`.

    Its sentence says of ``what`` the function is, where Numba stopped and why; all that Numba says is its cause.
    """

    @functools.wraps(getattr(function, "py_func", function))
    def call(*arguments):
        try:
            return function(*arguments)
        except Exception as error:  # compiled code raises nothing; Numba stops in many ways
            raise ParamsError(f"{what} cannot be compiled by Numba: {_reason(error)}") from error

    return call


def _reason(error):
    """Where Numba stopped outside this package, and what it says first, in one line."""
    if not isinstance(error, numba.core.errors.NumbaError):
        return f"{type(error).__name__}: {error}".splitlines()[0]
    lines = [line.strip() for line in str(error).splitlines()]
    here = re.escape(str(Path(__file__).resolve().parent.name))
    places = [re.match(r'File "(.*)", line (\d+)', line) for line in lines]
    outside = [f"{place[1]}, line {place[2]}" for place in places if place and not re.search(rf"\b{here}/", place[1])]
    said = [line for line in lines if line and not line.startswith(("Failed in nopython", "During", "File", "- "))]
    return ": ".join([*outside[-1:], said[0] if said else "no reason given"])[:400]


@functools.cache
def parts_dir(root, digest, what):
    """Folder for the kernels of the package at ``root`` that call functions with this digest; None if there is none.

    If nothing is there yet, it says on standard error for ``what`` the first call compiles.
    """
    folder = kernel_cache.find(Path(root.stem) / f"{_digest(root)}-{digest}")
    if not numba.config.DISABLE_JIT and (folder is None or not any(folder.rglob("*.nbi"))):
        kernel_cache.tell(f"compiling its kernels for {what}, once (about 20 s)")
    return folder


def digest_of(*functions):
    """Digest of functions from outside this package, as kernels that call them are compiled.

    It covers their code, the values that they find by name, the functions that they call, and the sources of the
    packages that these are from. What this package holds is covered by `cache_dir`.
    """
    state, seen = hashlib.sha256(numba.__version__.encode()), set()
    for function in functions:
        _add_value(state, seen, function)
    return state.hexdigest()[:24]


def _add_value(state, seen, value):
    """Add to a digest what a kernel may see of a value."""
    value = getattr(value, "py_func", value)
    if isinstance(value, types.FunctionType | types.ModuleType | type):
        name = value.__name__ if isinstance(value, types.ModuleType) else value.__module__
        state.update(f"{name} {getattr(value, '__qualname__', '')} ".encode())
        if id(value) in seen or name.partition(".")[0] in (
            Path(__file__).parent.name,
            "numpy",
            *sys.stdlib_module_names,
        ):
            return
        seen.add(id(value))
        _add_sources(state, seen, name)
    if isinstance(value, types.FunctionType):
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        _add_code(state, value.__code__)
        found = [value.__globals__[name] for name in value.__code__.co_names if name in value.__globals__]
        for part in (*cells, *found, *(value.__defaults__ or ())):
            _add_value(state, seen, part)
    elif isinstance(value, tuple | list):
        for part in value:
            _add_value(state, seen, part)
    elif hasattr(value, "tobytes"):  # an array or a scalar of NumPy
        state.update(f"{value.dtype} {value.shape} ".encode() + value.tobytes())
    elif not isinstance(value, types.ModuleType | type):
        state.update(f"{value!r} ".encode())


def _add_code(state, code):
    """Add to a digest the instructions of a function and what they name."""
    state.update(code.co_code + f" {code.co_names} {code.co_varnames} ".encode())
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _add_code(state, constant)
        else:
            state.update(f"{constant!r} ".encode())


def _add_sources(state, seen, module):
    """Add to a digest the sources of the package of a module, where there are any."""
    top = sys.modules.get(module.partition(".")[0])
    folder = next(iter(getattr(top, "__path__", ())), None)
    root = Path(folder or getattr(top, "__file__", None) or "")
    if root not in seen and root.exists() and (root.is_dir() or root.suffix == ".py") and root != Path():
        seen.add(root)
        state.update(_digest(root.resolve()).encode())
