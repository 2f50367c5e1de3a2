"""An entry: a folder with `entry.toml`, a card, and the two files of a learned policy; nothing else, nothing that runs.

`policy = "folder"` enters the folder `policy` beside `entry.toml`; any other value is a policy of the package with
options, such as `orthogonal:radius_m=30`, or a filter round the folder, `cbf+folder`.
"""

from __future__ import annotations

import datetime
import hashlib
import os
import stat
import tomllib
from dataclasses import dataclass
from pathlib import Path

from rss_gym import baselines
from rss_gym.baselines.policy_files import DOCUMENT, DOCUMENT_LIMIT, WEIGHTS
from rss_gym.eval.board.names import check_name, folded, reserved
from rss_gym.eval.policies import innermost
from rss_gym.eval.reading.plain import RecordError, checked, read_file
from rss_gym.eval.suites import SUITES, Suite
from rss_gym.params import ParamsError
from rss_gym.schema import Kind, Schema, line, matching, version

ENTRY, CARD, POLICY, FOLDER, ALL = "entry.toml", "card.md", "policy", "folder", "all"
FORMAT = 1
WEIGHTS_BYTES_MAX = 16 * 2**20
FILES = {  # name -> bytes at most
    ENTRY: 4096,
    CARD: 64 * 1024,
    f"{POLICY}/{DOCUMENT}": DOCUMENT_LIMIT,
    f"{POLICY}/{WEIGHTS}": WEIGHTS_BYTES_MAX,
}


DATE = Kind(lambda value: type(value) is datetime.date, "a date such as 2026-11-27, without quotes")
FIELDS: Schema = {
    "format": version(FORMAT),
    "name": Kind(lambda value: isinstance(value, str), "text"),
    "author": line(80),
    "date": DATE,
    "licence": matching(r"[A-Za-z0-9.+-]{1,40}", "an SPDX identifier such as MIT"),
    "link": matching(
        r"https://[A-Za-z0-9.-]+(?::\d{1,5})?(?:/[A-Za-z0-9._~/?#=&%+@-]*)?",
        "a link to the code that begins with https://",
    ),
    "suite": Kind(lambda value: isinstance(value, str), "the name of a suite, or all"),
    "policy": line(200, words=f"{FOLDER!r}, or a policy of the package such as orthogonal:radius_m=30"),
}


@dataclass(frozen=True)
class Submission:
    """An entry that has been read.

    Attributes
    ----------
    folder : Path
    name, author, date, licence, link, suite, policy : str
        As in `entry.toml`.
    card : str
        Text, shown as text.
    hash : str
        SHA-256 of the names and contents of all files.
    policy_hash : str
        SHA-256 of what is flown: the same for a copy of the entry under another name.
    """

    folder: Path
    name: str
    author: str
    date: str
    licence: str
    link: str
    suite: str
    policy: str
    card: str
    hash: str
    policy_hash: str

    @property
    def spec(self) -> str:
        """What the evaluator builds the policy by."""
        if innermost(self.policy) != FOLDER:
            return self.policy
        return self.policy.removesuffix(FOLDER) + str((self.folder / POLICY).absolute())

    def flies(self, suite: Suite) -> bool:
        """Whether it is entered for a suite."""
        return self.suite in (ALL, suite.name)


def read(folder: str | os.PathLike[str]) -> Submission:
    """The entry in a folder.

    Raises
    ------
    RecordError
        If it is no intact entry: the sentence names file, field, value and what would be right.
    """
    root = Path(folder)
    content = _files(root)
    file = str(root / ENTRY)
    try:
        table = tomllib.loads(content[ENTRY].decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordError(f"{file} is not TOML: {error}") from error
    fields = checked(file, "", table, FIELDS)
    try:
        check_name(fields["name"], fields["policy"])
        _check_policy(fields["policy"], f"{POLICY}/{DOCUMENT}" in content)
    except ParamsError as error:
        raise RecordError(f"{file}: {error}") from error
    if fields["suite"] != ALL and fields["suite"] not in SUITES:
        raise RecordError(f"{file}: suite = {fields['suite'][:60]!r} must be {ALL} or one of {', '.join(SUITES)}")
    if folded(fields["author"]) in reserved():
        raise RecordError(f"{file}: author = {fields['author']!r} is reserved; write who sends the entry")
    try:
        card = content.get(CARD, b"").decode("utf-8")
    except UnicodeDecodeError as error:
        raise RecordError(f"{root / CARD} is not text in UTF-8: {error}") from error
    flown = [fields["policy"].encode(), *(content.get(name, b"") for name in list(FILES)[2:])]
    return Submission(
        folder=root,
        **{name: fields[name] for name in ("name", "author", "licence", "link", "suite", "policy")},
        date=fields["date"].isoformat(),
        card=card,
        hash=_digest([part for name in FILES if name in content for part in (name.encode(), content[name])]),
        policy_hash=_digest(flown),
    )


def _check_policy(policy: str, has_files: bool) -> None:
    """Refuse what is neither the folder nor a policy of the package; no other path is ever looked at."""
    inner = innermost(policy)
    if inner == FOLDER and not has_files:
        raise ParamsError(f"policy = {policy!r} needs {POLICY}/{DOCUMENT} and {POLICY}/{WEIGHTS}")
    if inner != FOLDER and not baselines.is_known(inner):
        raise ParamsError(f"policy = {policy!r:.80} must be {FOLDER!r}, or a policy of the package: code is not flown")
    if inner != FOLDER and has_files:
        raise ParamsError(f"policy = {policy!r} does not use the files in {POLICY}/; write policy = {FOLDER!r}")


def _files(root: Path) -> dict[str, bytes]:
    """The content of every file of the entry, all of them plain and no larger than they may be."""
    found: list[str] = []
    try:
        if root.is_symlink() or not root.is_dir():
            raise RecordError(f"{str(root)!r} is not a folder; an entry is a folder with {ENTRY}")
        names = sorted(os.listdir(root))[: 2 * len(FILES)]
        for name in names:
            path = root / name
            if name == POLICY and stat.S_ISDIR(path.lstat().st_mode):
                found += [f"{name}/{inside}" for inside in sorted(os.listdir(path))[: 2 * len(FILES)]]
            else:
                found.append(name)
    except OSError as error:
        raise RecordError(f"{root} cannot be read: {error}") from error
    for name in found:
        if name not in FILES:
            raise RecordError(f"{root / name!s:.200} is no part of an entry, which holds only {', '.join(FILES)}")
    content = {name: read_file(root / name, FILES[name]) for name in found}
    if ENTRY not in content:
        raise RecordError(f"{root / ENTRY} is missing; rss-gym submit init DIR makes one")
    return content


def _digest(parts: list[bytes]) -> str:
    """SHA-256 of byte strings, each with its length."""
    total = hashlib.sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "little") + part)
    return total.hexdigest()
