"""Functions that add parts of your own to the package. Each imports what it needs when it is called."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rss_gym import registry

if TYPE_CHECKING:
    from rss_gym.baselines.policy import Scripted
    from rss_gym.encounters.family import Family
    from rss_gym.eval.metrics import Metric
    from rss_gym.eval.suites import Suite
    from rss_gym.params import Channel
    from rss_gym.ranging import Estimator
    from rss_gym.tracking import Tracker

__all__ = [
    "register_channel",
    "register_estimator",
    "register_family",
    "register_metric",
    "register_rule",
    "register_suite",
    "register_tracker",
]


def register_channel(name: str, channel: Channel | Mapping[str, Any] | str | os.PathLike[str], summary: str) -> None:
    """Add a preset of the radio channel: `channel="name"` then works wherever a shipped preset does.

    Parameters
    ----------
    name : str
    channel : Channel, mapping or path
        As in `rss_gym.params.load_channel`; a file is read now.
    summary : str
        One line that says where the numbers are from.

    Raises
    ------
    ParamsError
        For a name that is taken, or what is no channel.
    """
    from rss_gym.params import Preset, load_channel

    registry.of("channel").register(name, Preset(load_channel(channel), summary))


def register_estimator(name: str, estimator: Estimator) -> None:
    """Add an estimator of range: `estimator="name"` then flies it, `rss_gym.ranging.track` runs it over records.

    `rss-gym calibrate` compares it too. One with a run over records and without a filter does not fly.

    Raises
    ------
    ParamsError
        For a name that is taken, or what is no `rss_gym.ranging.Estimator`.
    """
    registry.of("estimator").register(name, estimator)


def register_family(name: str, family: Family) -> None:
    """Add a family of encounters; `families=["name"]` flies it. Its weight in `mixed` is 0.

    Raises
    ------
    ParamsError
        For a name that is taken, what is no `rss_gym.encounters.family.Family`, or a weight.
    """
    registry.of("family").register(name, family)


def register_rule(name: str, rule: type[Scripted]) -> None:
    """Add a scripted policy: `name` with its options then works wherever `orca` does.

    Parameters
    ----------
    name : str
    rule : type
        A frozen dataclass that derives from `rss_gym.baselines.policy.Scripted` and writes `act`; fields made by
        `rss_gym.params.number` are its options.

    Raises
    ------
    ParamsError
        For a name that is taken, or what is no such class.
    """
    registry.of("rule").register(name, rule)


def register_metric(name: str, metric: Metric) -> None:
    """Add a score: every evaluation computes it, and `scores.json` and the report hold it.

    Raises
    ------
    ParamsError
        For a name that is taken, or what is no `rss_gym.eval.metrics.Metric`.
    """
    registry.of("metric").register(name, metric)


def register_suite(suite: Suite) -> None:
    """Add a suite under its own name: `evaluate(..., suite="name-v0")` flies it.

    Raises
    ------
    ParamsError
        For a name that is taken or has no version, or what is no `rss_gym.eval.suites.Suite`.
    """
    registry.of("suite").register(getattr(suite, "name", ""), suite)


def register_tracker(name: str, tracker: Tracker) -> None:
    """Add a tracker of an intruder's relative state: `tracker="name"` then flies it.

    Raises
    ------
    ParamsError
        For a name that is taken, or what is no `rss_gym.tracking.Tracker`.
    """
    registry.of("tracker").register(name, tracker)
