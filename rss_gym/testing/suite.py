"""What every suite must keep."""

from __future__ import annotations

import dataclasses
import json

from rss_gym.domain import from_dict
from rss_gym.eval.evaluate import evaluate
from rss_gym.eval.suites import SUITES

EPISODES = 20


def check_suite(name: str) -> None:
    """Its definition travels as JSON and its hash follows what it covers; it flies, the same again."""
    suite = SUITES[name]
    assert suite.name == name and suite.summary.strip(), f"suite {name!r} has no summary"
    assert json.loads(json.dumps(suite.definition, allow_nan=False)), f"suite {name!r} has no definition"
    assert from_dict(json.loads(json.dumps(suite.params.to_dict()))) == suite.params
    assert dataclasses.replace(suite, summary="another").hash == suite.hash, "the hash must not cover the summary"
    assert dataclasses.replace(suite, name="another-v0").hash != suite.hash, "the hash must cover the name"
    episodes = min(EPISODES, suite.episodes)
    results = [evaluate("none", suite=suite, episodes=episodes, progress=False) for _ in range(2)]
    assert results[0]["none"] == results[1]["none"], f"suite {name!r} gives other scores when flown again"
    assert results[0]["none"]["cost_m"].value is not None, f"suite {name!r} has no cost"
