"""What every run records of its making, whatever it trains: names of its files, packages, revision."""

from __future__ import annotations

import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rss_gym.baselines.policy_files import DOCUMENT, WEIGHTS
from rss_gym.eval import records
from rss_gym.schema import argument, whole

RUN, AGENT, BEST = "run.json", "agent", "best"
FORMAT = 1
COUNT_MAX = 1000


def check_count(name: str, value: Any) -> None:
    """Refuse a number of seeds or workers outside [1, COUNT_MAX]."""
    argument(name, value, whole(1, COUNT_MAX))


def versions(*names: str) -> dict[str, str]:
    """Of Python, this package and what it computes with, and of these packages."""
    found = dict(records.versions())
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def revision() -> str | None:
    """The Git revision of this package's sources, `-dirty` after changes; None outside a repository of its own."""

    def git(*arguments: str) -> str:
        here = Path(__file__).resolve().parent
        return subprocess.run(["git", *arguments], cwd=here, capture_output=True, text=True, check=True).stdout.strip()

    try:
        git("ls-files", "--error-unmatch", Path(__file__).name)
        return git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.CalledProcessError):
        return None


def copy_policy(policy: Path, folder: Path) -> None:
    """Copy both files of a policy."""
    for file in (DOCUMENT, WEIGHTS):
        shutil.copyfile(policy / file, folder / file)
