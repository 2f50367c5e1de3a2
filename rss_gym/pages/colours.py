"""One colour for each policy and for each estimator, in every chart, table and replay: classes of the style sheet."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

CLASSES = tuple(f"c{number}" for number in range(9))
"""The classes that tell curves apart."""
NOMINAL = "nominal"
POLICIES = {
    "none": NOMINAL, "orthogonal": "c0", "orca": "c1", "mvp": "c2", "cbf": "c3", "mpc": "c4",
    "qmdp": "c8", "modified-orthogonal": "c5", "pathwise-plane": "c6", "pathwise-space": "c6", "pathwise-radios": "c6",
    "ppo-plane": "c7", "ppo-range": "c7", "ppo-merge": "c7",
}  # fmt: skip
ESTIMATORS = {
    "ls": "c7", "ls-window": "c6", "ekf-white-r": "c4", "ekf-white": "c1", "ekf-coloured-literal": "c5",
    "ekf-coloured": "c0", "ekf-log": "c2",
}  # fmt: skip


@cache
def light() -> dict[str, str]:
    """Class, or other variable of the style sheet such as `ink` -> its colour in the light scheme."""
    style = (Path(__file__).parent / "style.css").read_text(encoding="utf-8").partition("}")[0]
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]+)", style))


def class_of(spec: str) -> str | None:
    """The class of a policy, whatever its options; None for one that is not of the package."""
    return POLICIES.get(re.split("[:@+]", spec, maxsplit=1)[0])


def of_policy(spec: str) -> str:
    """The colour of a policy of the package in the light scheme: `#rrggbb`.

    Parameters
    ----------
    spec : str
        As in `rss_gym.baselines.make`, such as `orca:radius_m=20`.
    """
    return light()[class_of(spec) or NOMINAL]


def of_estimator(name: str) -> str:
    """The colour of an estimator in the light scheme."""
    return light()[ESTIMATORS[name]]
