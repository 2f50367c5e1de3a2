"""Writes a run: `scores.json`, one episode table a policy, and the files of learned policies.

A table is an `.npz` without objects and on request a `.csv`; a learned policy that was given by its folder travels in
the record, so that whoever verifies it needs no path of another machine.
"""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import json
import os
import platform
import re
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym.baselines.policy_files import DOCUMENT, WEIGHTS
from rss_gym.eval.evaluate import Result, Scored
from rss_gym.eval.policies import Entry, files
from rss_gym.files import new_folder

SCORES, TABLES, POLICIES = "scores.json", "tables", "policies"
SCHEMA = 4  # raised when fields of scores.json or columns of the tables change


def versions(*more: str) -> dict[str, str]:
    """Versions of everything that the numbers could depend on, `more` packages among them."""
    found = {"python": platform.python_version(), "machine": platform.machine()}
    for name in ("rss-gym", "numpy", "numba", "scipy", "gymnasium", *more):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def save(
    result: Result,
    out: str | os.PathLike[str],
    with_csv: bool = False,
    page: Callable[[Result, Path], object] | None = None,
) -> Path:
    """Write `scores.json`, the tables and a `page` into the new folder `out`; an error leaves nothing behind."""
    with new_folder(out) as folder:
        (folder / TABLES).mkdir()
        policies = []
        for index, scored in enumerate(result.policies):
            stem = f"{index:02d}-{re.sub('[^A-Za-z0-9.=_-]+', '-', scored.entry.name)[:80]}"
            written = write_table(folder / TABLES, stem, scored.table, with_csv)
            policies.append(_policy(scored, {"folder": write_policy(folder, stem, scored.entry), **written}))
        _write_json(folder / SCORES, document(result, policies))
        if page is not None:
            page(result, folder)
    return Path(out)


def document(result: Result, policies: list[dict[str, Any]]) -> dict[str, Any]:
    """`scores.json` as a dict."""
    return {
        "schema": SCHEMA,
        "suite": result.suite.name,
        "suite_hash": result.suite.hash,
        "split": result.suite.split,
        "seed": result.seed,
        "episodes": result.episodes,
        "first_episode": result.first_episode,
        "official": result.official,
        "reference": result.reference,
        "families": result.suite.families,
        "params": result.suite.params.to_dict(),
        "versions": versions(*result.suite.domain.packages),
        "policies": policies,
    }


def _policy(scored: Scored, written: dict[str, Any]) -> dict[str, Any]:
    return {
        "name": scored.entry.name,
        "spec": scored.entry.spec,
        "hash": scored.entry.hash,
        "information": scored.entry.params.interface.information,
        "action": scored.entry.action,
        "metrics": {name: dataclasses.asdict(estimate) for name, estimate in scored.metrics.items()},
        **written,
    }


def write_policy(folder: Path, stem: str, item: Entry) -> str | None:
    """Copy the files of a policy that a folder was given for; returns their folder below `folder`, None without."""
    content = files(item)
    if content is None:
        return None
    target = folder / POLICIES / stem
    target.mkdir(parents=True)
    for name, data in zip((DOCUMENT, WEIGHTS), content, strict=True):
        (target / name).write_bytes(data)
    return f"{POLICIES}/{stem}"


def write_table(folder: Path, stem: str, table: np.ndarray, with_csv: bool) -> dict[str, str]:
    """Write one table, a column an array; returns its file name and the digest of its bytes."""
    assert table.dtype.names is not None
    columns: dict[str, Any] = {name: table[name] for name in table.dtype.names}
    np.savez_compressed(folder / f"{stem}.npz", **columns)
    if with_csv:
        with open(folder / f"{stem}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(table.dtype.names)
            writer.writerows(table.tolist())
    return {"table": f"{TABLES}/{stem}.npz", "table_sha256": table_digest(table)}


def table_digest(table: np.ndarray) -> str:
    """SHA-256 of a table's rows in memory, which is the same on every machine; a compressed file's is not."""
    return hashlib.sha256(np.ascontiguousarray(table).view(np.uint8).data).hexdigest()


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=1, allow_nan=False) + "\n", encoding="utf-8")
