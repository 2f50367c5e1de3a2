"""What the board says of an entry on a suite: scores from the tables that it has flown itself."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from rss_gym.eval.board.entry import Submission
from rss_gym.eval.board.season import Flown, Season
from rss_gym.eval.columns import columns_of
from rss_gym.eval.costs import Costs, Prices
from rss_gym.eval.evaluate import score
from rss_gym.eval.policies import entry
from rss_gym.eval.records import table_digest, versions
from rss_gym.eval.suites import Suite
from rss_gym.eval.workers import NOMINAL
from rss_gym.params import ParamsError

KIND = "verdict"
RULES = 1  # raised when what the board flies or checks changes: entries are flown again, and lines appended
COLUMNS = ("cost_m", "collision_rate", "snmac_rate", "path_deviation_mean_m")


def key_of(season: str, rules: int, suite_hash: str, entry_hash: str) -> tuple[str, int, str, str]:
    """What is flown once."""
    return season, rules, suite_hash, entry_hash


def verdict(
    season: Season, flown: Flown, submission: Submission, public: tuple[np.ndarray, ...], sealed: tuple[np.ndarray, ...]
) -> dict[str, Any]:
    """The line of an entry that was flown; `public` and `sealed` hold the tables of `none` and of the entry."""
    suite = flown.suite()
    parts = {"public": _part(suite, suite.seed, submission, *public), "sealed": _part(suite, 0, submission, *sealed)}
    faults = sum(int(np.count_nonzero(tables[1]["fault"])) for tables in (public, sealed))
    information = entry(submission.spec, suite.params, submission.name).params.interface.information
    return _line(season, flown, submission, suite) | {
        **parts,
        "information": information,
        "faults": faults,
        "gap_m": gap(parts["public"], parts["sealed"], "cost_m"),
        "deviation_gap_m": gap(parts["public"], parts["sealed"], "path_deviation_mean_m"),
        "failed": None,
    }


def failed(season: Season, flown: Flown, submission: Submission, why: str) -> dict[str, Any]:
    """The line of an entry that could not be flown to its end: it has no place."""
    return _line(season, flown, submission, flown.suite()) | {"failed": why[:500]}


def gap(public: dict[str, Any], sealed: dict[str, Any], name: str) -> dict[str, float | None]:
    """By how much a metric is larger on the sealed encounters than on the public ones, from the ends of both intervals.

    That is wider than an interval of the difference need be, so an alarm by it is rarely false.
    """
    one, other = public["metrics"][name], sealed["metrics"][name]
    if None in (one["low"], other["low"]):
        return {"value": None, "low": None, "high": None}
    ends = {"low": other["low"] - one["high"], "high": other["high"] - one["low"]}
    return {"value": other["value"] - one["value"], **ends}


def _line(season: Season, flown: Flown, submission: Submission, suite: Suite) -> dict[str, Any]:
    fields = ("name", "author", "date", "licence", "link", "policy", "card")
    return {
        "kind": KIND,
        "rules": RULES,
        "season": season.name,
        "commitment": season.commitment,
        "suite": flown.name,
        "suite_hash": flown.hash,
        "entry_hash": submission.hash,
        "policy_hash": submission.policy_hash,
        "entry": {name: getattr(submission, name) for name in fields},
        "versions": versions(*suite.domain.packages),
    }


def _part(suite: Suite, seed: int, submission: Submission, none: np.ndarray, table: np.ndarray) -> dict[str, Any]:
    """Scores of one set of encounters, whole and by family and radio."""
    nominal = entry(NOMINAL, suite.params, NOMINAL)
    own = dataclasses.replace(nominal, name=submission.name if submission.name != NOMINAL else "entry")
    metrics = score(suite, seed, [nominal, own], [none, table], NOMINAL, False)[own.name]
    prices = Prices.of(suite.params)
    names = suite.families
    families = {names[k]: _mean(table[table["family"] == k], prices) for k in np.unique(table["family"]).tolist()}
    radios = {str(k): _mean(table[table["channel"] == k], prices) for k in np.unique(table["channel"]).tolist()}
    worst = np.lexsort((table["episode"], table["min_separation_m"], -table["cost_m"]))[:3]
    return {
        "episodes": len(table),
        "table_sha256": table_digest(table),
        "metrics": {
            name: dataclasses.asdict(metrics[name])
            for name in dict.fromkeys((*COLUMNS, *columns_of(suite.params)))
            if name in metrics
        },
        "families": families,
        "radios": radios,
        "worst": [int(number) for number in table["episode"][worst]],
    }


def _mean(table: np.ndarray, prices: Prices) -> dict[str, Any]:
    costs = Costs.of(table, prices)
    interval = costs.interval()
    return {"n": len(costs), "cost_m": costs.mean_m, "low": interval.low, "high": interval.high}


def refuse_not_finite(line: dict[str, Any]) -> None:
    """Refuse a line with a score that is not finite, which JSON cannot hold."""
    for part in ("public", "sealed"):
        for name, metric in line.get(part, {}).get("metrics", {}).items():
            if not all(value is None or math.isfinite(value) for value in (metric["value"], metric["low"])):
                raise ParamsError(f"{part} {name} of entry {line['entry']['name']!r} is not finite")
