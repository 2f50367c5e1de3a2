"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rss_gym.params import ParamsError


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
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name[:80]}-", dir=target.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.chmod(temporary, 0o644)
            os.replace(temporary, target)
        except BaseException:
            os.unlink(temporary)
            raise
    except (OSError, ValueError) as error:  # ValueError: a null in the name
        raise ParamsError(f"file {str(path)!r} cannot be written: {error}") from error
    return target


@contextmanager
def new_folder(out: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary folder beside `out` that becomes `out` when the block ends without an error.

    Raises
    ------
    ParamsError
        If `out` exists and is not an empty folder, or cannot be written.
    """
    target = check_new(out)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name[:80]}-", dir=target.parent))
        try:
            yield temporary
            temporary.chmod(0o755)
            if target.is_dir():
                target.rmdir()
            temporary.rename(target)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    except OSError as error:
        raise ParamsError(f"output folder {str(out)!r} cannot be written: {error}") from error


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
        if target.exists():
            target.rename(old)
        new.rename(target)
    shutil.rmtree(old, ignore_errors=True)


def tidy(parent: Path, *names: str) -> None:
    """Clear what a killed process left of the files and replaced folders `names` in `parent`."""
    for name in names:
        old = _aside(parent / name)
        if old.exists() and not (parent / name).exists():
            old.rename(parent / name)
        for left in (old, *parent.glob(f".{name}-*")):
            if left.is_dir():
                shutil.rmtree(left)
            else:
                left.unlink(missing_ok=True)


def _aside(target: Path) -> Path:
    return target.with_name(f".{target.name}.old")


def check_new(out: str | os.PathLike[str]) -> Path:
    """The absolute path of a folder that can be made; called before a long run, not after it. Nothing is made.

    Raises
    ------
    ParamsError
        As `new_folder`.
    """
    if "\0" in os.fspath(out):
        raise ParamsError(f"output folder {str(out)!r} cannot be written: no name holds a null")
    target = Path(out).absolute()
    try:
        if target.is_dir() and any(target.iterdir()):
            raise ParamsError(f"output folder {str(out)!r} exists and is not empty; name a new one")
        if target.exists() and not target.is_dir():
            raise ParamsError(f"output folder {str(out)!r} is a file; name a new folder")
        with tempfile.TemporaryFile(dir=next(folder for folder in target.parents if folder.exists())):
            pass
    except OSError as error:
        raise ParamsError(f"output folder {str(out)!r} cannot be written: {error}") from error
    return target
