"""A whole record, its tables read and compared with what it says of them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rss_gym.baselines.policy_files import DOCUMENT, DOCUMENT_LIMIT, WEIGHTS, WEIGHTS_LIMIT
from rss_gym.domain import domain_of
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.reading.plain import RecordError, checked, opened, parse, read_file, shown
from rss_gym.eval.reading.schema import POLICIES_OF, RECORD, metrics_of, params_of
from rss_gym.eval.reading.table_file import check_rows, read_table
from rss_gym.eval.records import POLICIES, SCORES, TABLES, table_digest
from rss_gym.eval.table import TABLES as COLUMNS
from rss_gym.eval.workers import NOMINAL
from rss_gym.params import Params

SCORES_BYTES_MAX = 8 * 2**20
TABLES_BYTES_MAX = 4 * 2**30
# Properties of the encounter, whoever flies; a drive ends at a time of its own.
_SHARED = {"air": ("family", "channel", "duration_s", "approach_s"), "road": ("family", "channel")}


@dataclass(frozen=True)
class Policy:
    """One policy of a record."""

    name: str
    spec: str
    hash: str
    information: str
    action: str | None  # None where the record does not tell
    metrics: dict[str, Estimate]
    file: str  # of the table, below the record's folder
    table_sha256: str
    table: np.ndarray
    folder: str | None  # of the policy's own files, below the record's folder


@dataclass(frozen=True)
class Record:
    """What `load` has found to be sound; whether it is true, `verify` says."""

    folder: Path
    suite: str
    suite_hash: str
    split: str
    seed: int
    episodes: int
    first_episode: int
    official: bool
    reference: str
    families: tuple[str, ...]
    params: Params
    versions: dict[str, str]
    policies: tuple[Policy, ...]

    def __getitem__(self, name: str) -> Policy:
        """The policy of that name."""
        return next(policy for policy in self.policies if policy.name == name)


def load(folder: str | os.PathLike[str]) -> Record:
    """The record in a folder that `records.save` wrote, with its tables.

    Raises
    ------
    RecordError
        For anything else.
    """
    root = Path(folder)
    file = root / SCORES
    if not root.is_dir():
        raise RecordError(f"{str(folder)!r} is not a folder; a record is a folder with a {SCORES}")
    content = parse(read_file(file, SCORES_BYTES_MAX), str(file))
    fields = checked(str(file), "", content, RECORD)
    params, families = params_of(str(file), fields["params"])
    if fields["families"] != families:
        raise RecordError(f"{file}: families = {shown(fields['families'])} must be {families}, those of its parameters")
    domain = domain_of(params)
    columns = COLUMNS[domain.name]
    if (root / TABLES).is_symlink():
        raise RecordError(f"{root / TABLES} is a symbolic link; a record holds plain files and folders")
    size = fields["episodes"] * len(fields["policies"]) * columns.itemsize
    if size > TABLES_BYTES_MAX:
        raise RecordError(
            f"{file}: {len(fields['policies'])} policies of {fields['episodes']} episodes are {size} bytes of tables; "
            f"they must be at most {TABLES_BYTES_MAX}"
        )
    policies: list[Policy] = []
    for index, item in enumerate(fields["policies"]):
        where = f"policies[{index}]"
        values = checked(str(file), where, item, POLICIES_OF[fields["schema"]])
        metrics = metrics_of(str(file), f"{where}.metrics", values["metrics"], domain.name)
        taken = {"name": {p.name for p in policies}, "table": {p.file for p in policies}}
        taken["folder"] = {p.folder for p in policies if p.folder}
        for field, other in taken.items():
            if values[field] in other:
                raise RecordError(f"{file}: {where}.{field} = {values[field]!r} is given twice; it must be unique")
        if values["name"] == NOMINAL != values["spec"]:
            raise RecordError(f"{file}: {where}.spec = {values['spec']!r} must be {NOMINAL!r} as the name is")
        table = read_table(root / values["table"], fields["episodes"], columns)
        check_rows(str(root / values["table"]), table, params, len(families), fields["first_episode"])
        if table_digest(table) != values["table_sha256"]:
            raise RecordError(
                f"{file}: {where}.table_sha256 = {values['table_sha256']!r} must be {table_digest(table)!r}, the "
                f"digest of {values['table']}: table or record was changed"
            )
        if values["folder"] is not None:
            _check_folder(root, values["folder"])
        names = {key: values[key] for key in ("name", "spec", "hash", "information", "table_sha256", "folder")}
        names["action"] = values.get("action")
        policies.append(Policy(**names, metrics=metrics, file=values["table"], table=table))
    record = Record(
        folder=root,
        params=params,
        families=tuple(families),
        policies=tuple(policies),
        **{key: fields[key] for key in RECORD if key not in ("schema", "families", "params", "policies")},
    )
    _check_policies(str(file), record)
    return record


def _check_folder(root: Path, folder: str) -> None:
    """Refuse a policy's folder that is a link, or whose two files are not plain files of the right size."""
    for place in (root / POLICIES, root / folder):
        if place.is_symlink():
            raise RecordError(f"{place} is a symbolic link; a record holds plain files and folders")
    for name, limit in ((DOCUMENT, DOCUMENT_LIMIT), (WEIGHTS, WEIGHTS_LIMIT)):
        opened(root / folder / name, limit).close()


def _check_policies(file: str, record: Record) -> None:
    names = [policy.name for policy in record.policies]
    for name in (NOMINAL, record.reference):
        if name not in names:
            raise RecordError(
                f"{file}: policies must include {name!r}, which others are compared with; they are {names}"
            )
    none = record[NOMINAL]
    for policy in record.policies:
        for column in _SHARED[domain_of(record.params).name]:
            wrong = np.flatnonzero(policy.table[column] != none.table[column])
            if len(wrong):
                raise RecordError(
                    f"{record.folder / policy.file}: column {column!r} of episode {wrong[0]} is "
                    f"{policy.table[column][wrong[0]]}, must be {none.table[column][wrong[0]]} as in {none.file}: the "
                    "encounters are the same for every policy"
                )
