"""For who enters: make the files of an entry, and check them as the board does, all but the sealed encounters."""

from __future__ import annotations

import datetime
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from rss_gym import baselines
from rss_gym.baselines.policy_files import DOCUMENT, WEIGHTS
from rss_gym.eval.board.entry import CARD, ENTRY, FOLDER, POLICY, Submission, read
from rss_gym.eval.board.fly import Runner, check_policy
from rss_gym.eval.board.limits import Job, fly_limited
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.suites import SUITES, Suite
from rss_gym.files import new_folder, write_text
from rss_gym.params import ParamsError

EPISODES = 200  # of each suite that `check` flies unless told otherwise

_TEMPLATE = """\
format = 1
name = "{name}"
author = "{author}"      # who sends it; one entry for each author and suite counts
date = {date}
licence = "MIT"          # SPDX identifier of the code behind the link
link = "{link}"
suite = "{suite}"        # or "all"
policy = "{policy}"      # "folder" is the folder policy/; or a policy of the package with options
"""
_CARD = "How it was trained, on what, for how long; what it is good at, and where it fails.\n"


def init(
    folder: str | os.PathLike[str],
    policy: str,
    name: str = "my-agent",
    author: str = "your name",
    link: str = "https://example.org/my-agent",
    suite: str = "encounter-v0",
) -> Path:
    """Write the new folder of an entry.

    Parameters
    ----------
    folder : path
    policy : str
        Folder of a learned policy or of the run that trained it, whose files are copied; or a policy of the package.
    name, author, link, suite : str
        As in `entry.toml`, where they can be changed.

    Raises
    ------
    ParamsError
        If the folder exists, or there is no such policy.
    """
    source = baselines.folder_of(policy)
    if source is None and not baselines.is_known(policy):
        raise ParamsError(f"policy {policy!r} is neither the folder of a learned policy nor one of the package")
    for value in (name, author, link, suite, policy):
        if not value.isprintable() or '"' in value or "\\" in value:
            raise ParamsError(f"{value!r} must be printable text without quotes and backslashes")
    with new_folder(folder) as new:
        text = _TEMPLATE.format(
            name=name,
            author=author,
            link=link,
            suite=suite,
            date=datetime.date.today().isoformat(),
            policy=policy if source is None else FOLDER,
        )
        write_text(new / ENTRY, text)
        write_text(new / CARD, _CARD)
        if source is not None:
            (new / POLICY).mkdir()
            for file in (DOCUMENT, WEIGHTS):
                shutil.copyfile(Path(source) / file, new / POLICY / file)
    return Path(folder)


def check(
    folder: str | os.PathLike[str],
    episodes: int = EPISODES,
    runner: Runner = fly_limited,
    say: Callable[[str], object] = print,
) -> Submission:
    """Read an entry and fly public encounters of its suites in a child process, as the board does.

    Raises
    ------
    RecordError
        If the board would refuse it.
    ParamsError
        If it cannot fly in its suite, or, entered for all, in none.
    PolicyError
        If its flights take too much, or end with an error.
    """
    entry = read(folder)
    say(f"{entry.name} by {entry.author}: entry {entry.hash[:16]}, policy {entry.policy_hash[:16]}")
    suites, refused = [], []
    for suite in SUITES.values():
        if not entry.flies(suite):
            continue
        try:
            check_policy(entry, suite)
        except ParamsError as error:
            refused.append(f"{suite.name}: {error}")
        else:
            suites.append(suite)
    for why in refused:
        say(f"does not fly on {why}")
    if not suites:
        raise ParamsError(f"{folder}: it can fly on none of its suites; {refused[0]}")
    for line in _flown(entry, suites, episodes, runner):
        say(line)
    return entry


def _flown(entry: Submission, suites: list[Suite], episodes: int, runner: Runner) -> Iterator[str]:
    for suite in suites:
        count = min(episodes, suite.episodes)
        table = runner(Job(suite.name, suite.hash, entry.spec, entry.name, suite.split, suite.seed, 0, count))
        interval = Costs.of(table, Prices.of(suite.params)).interval()
        faults = int(np.count_nonzero(table["fault"]))
        text = f"{suite.name}: cost {interval.value:.4g} m" + (
            f" ({interval.low:.4g} to {interval.high:.4g})" if interval.low is not None else ""
        )
        yield f"{text} over {count} public encounters" + (f"; {faults} FAULTS: it would not be ranked" * bool(faults))
