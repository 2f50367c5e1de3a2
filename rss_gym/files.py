"""Files that appear whole or not at all, in folders that are held from the beginning of a work to its end."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from rss_gym.locking import free, take
from rss_gym.params import ParamsError

Saved = TypeVar("Saved")
MARK = ".unfinished"  # in a folder that is being filled; it names what a process that was killed has left
NEW = ".new-"
OURS = ("scores.json", "run.json", "policy.json", "paper.json", "calibration.json", "index.html", "report.html")
_held: dict[str, int | None] = {}  # real paths of the folders that this process holds -> descriptor of the mark


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write a text file in UTF-8 as `write_bytes` does."""
    return write_bytes(path, text.encode("utf-8", errors="replace"))


def write_bytes(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a file under a temporary name and rename it, so that no half-written file is ever seen.

    Raises
    ------
    ParamsError
        If it cannot be written.
    """
    target = Path(path)
    try:
        temporary = _beside(target)
        try:
            with open(temporary, "xb") as file:
                file.write(content)
            os.replace(temporary, target)
        except BaseException:
            with suppress(OSError):
                os.unlink(temporary)
            raise
    except (OSError, ValueError) as error:  # ValueError: a null in the name
        raise ParamsError(f"file {str(path)!r} cannot be written: {error}") from error
    return target


def _beside(target: Path) -> Path:
    """A name for a temporary file beside `target`."""
    return target.with_name(f".{target.name[:80]}-{secrets.token_hex(4)}")


@contextmanager
def new_folder(out: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary folder whose content becomes that of `out` when the block ends without an error.

    Raises
    ------
    ParamsError
        If `out` exists and is not an empty folder, or cannot be written. If its content is complete but cannot be
        moved there, it stays and the sentence names its place.
    """
    with reserved(out) as target:
        new = target / f"{NEW}{secrets.token_hex(4)}"
        try:
            new.mkdir()
            yield new
        except BaseException as error:
            shutil.rmtree(new, ignore_errors=True)
            if isinstance(error, OSError):
                raise ParamsError(f"output folder {str(out)!r} cannot be written: {error}") from error
            raise
        try:
            names = sorted(os.listdir(new))
            with suppress(OSError):
                (target / MARK).write_text("\n".join(names), encoding="utf-8")
            for name in names:
                os.replace(new / name, target / name)
            new.rmdir()
        except OSError as error:
            raise ParamsError(
                f"output folder {str(out)!r} cannot be filled: {error}; the results are in {str(new)!r}"
            ) from error


def save_or_keep(save: Callable[[Path], Saved], out: str | os.PathLike[str]) -> Saved:
    """What `save(out)` gives. Where it cannot write, what took long to compute is saved in the temporary folder.

    Raises
    ------
    ParamsError
        If it could not be saved in `out`; the sentence names the place where it is.
    """
    try:
        return save(Path(out))
    except (ParamsError, OSError) as error:
        try:
            other = Path(tempfile.mkdtemp(prefix="rss-gym-"))
        except OSError:
            raise error from None
        try:
            save(other / "results")
        except (ParamsError, OSError):
            shutil.rmtree(other, ignore_errors=True)
            raise error from None
        raise ParamsError(f"{error}; the results are in {str(other / 'results')!r}") from error


@contextmanager
def reserved(out: str | os.PathLike[str]) -> Iterator[Path]:
    """Make the new folder `out` and hold it until the block ends; one that is still empty then is removed.

    What a process that was killed has left in it is cleared. A block inside another for the same folder does nothing.

    Raises
    ------
    ParamsError
        If `out` exists and is not an empty folder, cannot be written, or is held by another process.
    """
    target = check_new(out)
    key = os.path.realpath(target)
    if key in _held:
        yield target
        return
    made: list[Path] = []
    try:
        for folder in [*reversed(target.parents), target]:
            if not folder.exists():
                folder.mkdir()
                made.append(folder)
        descriptor = _mark(target)
    except OSError as error:
        _remove(made)
        raise ParamsError(f"output folder {str(out)!r} cannot be written: {error}") from error
    _held[key] = descriptor
    try:
        yield target
    finally:
        with suppress(OSError):
            os.unlink(target / MARK)
        _release(_held.pop(key))
        _remove(made)


def _mark(target: Path) -> int:
    """Take the mark of a folder and clear what a killed process left there."""
    descriptor = os.open(target / MARK, os.O_RDWR | os.O_CREAT, 0o666)
    with suppress(OSError):  # a file system without locks
        if not take(descriptor):
            os.close(descriptor)
            raise ParamsError(f"output folder {str(target)!r} is being written by another process")
    for name in _left(target):
        _clear(target / name)
    os.ftruncate(descriptor, 0)
    return descriptor


def _clear(path: Path) -> None:
    """Remove a file, a folder with its content, or a link, but not what a link leads to."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _left(target: Path) -> list[str]:
    """What a killed process left in a folder, by its mark: temporary folders, and what it had begun to move."""
    try:
        named = (target / MARK).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return []
    return [name for name in os.listdir(target) if name.startswith(NEW) or name in named]


def _release(descriptor: int | None) -> None:
    if descriptor is not None:
        with suppress(OSError):
            free(descriptor)
        os.close(descriptor)


def _remove(folders: list[Path]) -> None:
    """Remove folders that are empty, the last first."""
    for folder in reversed(folders):
        with suppress(OSError):
            folder.rmdir()


@contextmanager
def overwritten(out: str | os.PathLike[str]) -> Iterator[None]:
    """Put an old folder aside while a new one is made in its place; it comes back if the block ends with an error.

    Raises
    ------
    ParamsError
        If the folder holds nothing that a command of this package has written.
    """
    target = Path(out).absolute()
    old = _aside(target)
    try:
        if old.is_dir() and (not target.exists() or (target / MARK).exists()):  # a process was killed here
            shutil.rmtree(target, ignore_errors=True)
            old.rename(target)
        is_old = target.is_dir() and not target.is_symlink() and any(target.iterdir())
        if is_old and not any(path for name in OURS for path in (*target.glob(name), *target.glob(f"*/{name}"))):
            raise ParamsError(
                f"output folder {str(out)!r} is not overwritten: it holds none of the files that rss-gym writes "
                f"({', '.join(OURS)})"
            )
        if is_old:
            shutil.rmtree(old, ignore_errors=True)
            target.rename(old)
    except OSError as error:
        raise ParamsError(f"output folder {str(out)!r} cannot be replaced: {error}") from error
    try:
        yield
    except BaseException:
        if is_old and not target.exists():
            old.rename(target)
        raise
    if is_old:
        shutil.rmtree(old, ignore_errors=True)


@contextmanager
def replaced_folder(target: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of `target` when the block ends without an error.

    A process that is killed leaves the old folder or the new one, and perhaps temporary ones: `tidy` removes these, and
    puts the old folder back if the end came between the two renames.
    """
    old = _aside(target)
    with tempfile.TemporaryDirectory(prefix=f".{target.name}-", dir=target.parent) as temporary:
        new = Path(temporary) / target.name
        new.mkdir()
        yield new
        if os.path.lexists(target):
            target.rename(old)
        new.rename(target)
    _clear(old)


def tidy(parent: Path, *names: str) -> None:
    """Clear what a killed process left of the files and replaced folders `names` in `parent`."""
    for name in names:
        old = _aside(parent / name)
        if os.path.lexists(old) and not os.path.lexists(parent / name):
            old.rename(parent / name)
        for left in (old, *parent.glob(f".{name}-*")):
            _clear(left)


def _aside(target: Path) -> Path:
    return target.with_name(f".{target.name}.old")


def check_new(out: str | os.PathLike[str]) -> Path:
    """The absolute path of a folder that can be made; called before a long run, not after it. Nothing is made.

    Raises
    ------
    ParamsError
        As `reserved`.
    """
    if "\0" in os.fspath(out):
        raise ParamsError(f"output folder {str(out)!r} cannot be written: no name holds a null")
    if not os.fspath(out):
        raise ParamsError("the name of the output folder is empty; name a new folder")
    target = Path(out).absolute()
    if os.path.realpath(target) in _held:
        return target
    try:
        if target.is_dir() and set(os.listdir(target)) - {MARK, *_left(target)}:
            link = " is a symbolic link, whose folder" if target.is_symlink() else ""
            way = "" if link else ", or give the command --overwrite"
            raise ParamsError(f"output folder {str(out)!r}{link} exists and is not empty; name a new one{way}")
        if target.is_symlink() and not target.exists():
            aim = os.readlink(target)
            raise ParamsError(
                f"output folder {str(out)!r} is a symbolic link to {aim!r}, which is no folder; name another"
            )
        if target.exists() and not target.is_dir():
            raise ParamsError(f"output folder {str(out)!r} is a file; name a new folder")
        with tempfile.TemporaryFile(dir=next(path for path in (target, *target.parents) if path.exists())):
            pass
    except OSError as error:
        raise ParamsError(f"output folder {str(out)!r} cannot be written: {error}") from error
    return target
