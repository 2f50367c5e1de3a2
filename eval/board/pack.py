"""An entry as one file, `.zip`: the same bytes from the same entry, and unpacked only within its bounds."""

from __future__ import annotations

import hashlib
import io
import os
import zipfile
from pathlib import Path

from rss_gym.eval.board.entry import FILES, read
from rss_gym.eval.reading.plain import RecordError, opened
from rss_gym.files import write_bytes

PACKED = ".zip"
PACKED_BYTES_MAX = sum(FILES.values())
_WHEN = (2020, 1, 1, 0, 0, 0)


def pack(folder: str | os.PathLike[str], out: str | os.PathLike[str]) -> Path:
    """Write the entry in a folder as one file.

    Raises
    ------
    RecordError
        If the entry would be refused.
    """
    read(folder)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in FILES:
            if (Path(folder) / name).is_file():
                archive.writestr(zipfile.ZipInfo(name, _WHEN), (Path(folder) / name).read_bytes())
    return write_bytes(out, buffer.getvalue())


def unpack(file: Path, into: Path) -> Path:
    """The folder in `into` with the files of a packed entry; nothing else in it is looked at, nothing larger is read.

    Raises
    ------
    RecordError
        If the file is no packed entry.
    """
    with opened(file, PACKED_BYTES_MAX) as stream:
        digest = hashlib.sha256(stream.read(PACKED_BYTES_MAX)).hexdigest()
        stream.seek(0)
        try:
            with zipfile.ZipFile(stream) as archive:
                members = archive.infolist()
                names = [member.filename for member in members]
                for member in members:
                    if member.filename not in FILES or names.count(member.filename) > 1:
                        raise RecordError(f"{file}: {member.filename!r:.100} is no part of an entry, or is there twice")
                    if member.file_size > FILES[member.filename]:
                        raise RecordError(
                            f"{file}: {member.filename} has {member.file_size} bytes; it must have at most "
                            f"{FILES[member.filename]}"
                        )
                content = {member.filename: _bounded(archive, member, file) for member in members}
        except (zipfile.BadZipFile, NotImplementedError, EOFError, RuntimeError, ValueError, OSError) as error:
            raise RecordError(f"{file} is no packed entry: {error}") from error
    target = into / digest[:32]
    for name, data in content.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        write_bytes(target / name, data)
    return target


def _bounded(archive: zipfile.ZipFile, member: zipfile.ZipInfo, file: Path) -> bytes:
    """A member's bytes, whatever size it claims."""
    limit = FILES[member.filename]
    with archive.open(member) as stream:
        data = stream.read(limit + 1)
    if len(data) > limit:
        raise RecordError(f"{file}: {member.filename} is larger than {limit} bytes")
    return data
