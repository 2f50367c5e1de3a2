"""The fields of `scores.json`, what each may hold, and what is made of the larger ones."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, get_args

from rss_gym.core import SEED_LIMIT, SPLITS
from rss_gym.domain import domain_of, from_dict
from rss_gym.eval.evaluate import NAME_MAX, is_name
from rss_gym.eval.metrics import METRICS, Estimate, defined_in
from rss_gym.eval.reading.plain import Checks, RecordError, checked, refuse_unknown, shown
from rss_gym.eval.reading.table_file import EPISODES_MAX
from rss_gym.eval.records import POLICIES, SCHEMA, TABLES
from rss_gym.highway.params import RoadParams
from rss_gym.params import ActionKind, Information, Params, ParamsError

POLICIES_MAX = 1000
CHANNELS_MAX = 64
SPEC_MAX = 1000
WITHOUT_ACTION = 3  # an older schema, whose policies do not say what they command


def _whole(low: int, high: int) -> Callable[[Any], bool]:
    return lambda value: type(value) is int and low <= value <= high


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= SPEC_MAX and value.isprintable()


def _is_limit(value: Any) -> bool:
    return value is None or (type(value) in (int, float) and abs(value) < 1e300)


_HEX = (lambda value: isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value) is not None, "64 hex digits")
_NAME = (is_name, f"1 to {NAME_MAX} printable characters")
_TEXT = (_is_text, f"at most {SPEC_MAX} printable characters")
_LIMIT = (_is_limit, "a finite number or null")
_TABLE_FILE = re.compile(TABLES + r"/[0-9]{2,4}-[A-Za-z0-9.=_-]{0,80}\.npz")
_FOLDER = re.compile(POLICIES + r"/[0-9]{2,4}-[A-Za-z0-9.=_-]{0,80}")

RECORD: Checks = {
    "schema": (
        lambda value: type(value) is int and value in (WITHOUT_ACTION, SCHEMA),
        f"{WITHOUT_ACTION} or {SCHEMA}, which this version reads",
    ),
    "suite": _NAME,
    "suite_hash": _HEX,
    "split": (lambda value: isinstance(value, str) and value in SPLITS, "one of " + ", ".join(SPLITS)),
    "seed": (_whole(0, SEED_LIMIT - 1), "a whole number in [0, 2**63)"),
    "episodes": (_whole(1, EPISODES_MAX), f"a whole number in [1, {EPISODES_MAX}]"),
    "first_episode": (_whole(0, SEED_LIMIT - 1), "a whole number in [0, 2**63)"),
    "official": (lambda value: isinstance(value, bool), "true or false"),
    "reference": _NAME,
    "families": (lambda value: isinstance(value, list), "a list of families"),
    "params": (lambda value: isinstance(value, dict), "a table of parameters"),
    "versions": (
        lambda value: (
            isinstance(value, dict)
            and len(value) <= 100
            and all(is_name(key) and is_name(text) for key, text in value.items())
        ),
        "a table of package names and versions",
    ),
    "policies": (
        lambda value: isinstance(value, list) and 1 <= len(value) <= POLICIES_MAX,
        f"a list of 1 to {POLICIES_MAX} policies",
    ),
}
POLICY: Checks = {
    "name": _NAME,
    "spec": _TEXT,
    "hash": _HEX,
    "information": (lambda value: value in get_args(Information), "one of " + ", ".join(get_args(Information))),
    "action": (lambda value: value in get_args(ActionKind), "one of " + ", ".join(get_args(ActionKind))),
    "metrics": (lambda value: isinstance(value, dict), "a table of metrics"),
    "table": (
        lambda value: isinstance(value, str) and _TABLE_FILE.fullmatch(value) is not None,
        f"a file such as {TABLES}/00-none.npz",
    ),
    "table_sha256": _HEX,
    "folder": (
        lambda value: value is None or (isinstance(value, str) and _FOLDER.fullmatch(value) is not None),
        f"null, or a folder such as {POLICIES}/01-mine",
    ),
}
POLICIES_OF: dict[int, Checks] = {
    WITHOUT_ACTION: {name: check for name, check in POLICY.items() if name != "action"},
    SCHEMA: POLICY,
}
ESTIMATE: Checks = {
    "value": _LIMIT,
    "low": _LIMIT,
    "high": _LIMIT,
    "n": (_whole(0, SEED_LIMIT - 1), "a whole number >= 0"),
    "unit": _TEXT,
}


def metrics_of(file: str, where: str, value: dict[str, Any], domain: str = "air") -> dict[str, Estimate]:
    """The metrics of a policy."""
    refuse_unknown(file, where, value, defined_in(domain))
    metrics = {}
    for name, item in value.items():
        fields = checked(file, f"{where}.{name}", item, ESTIMATE)
        if fields["unit"] != METRICS[name].unit:
            raise RecordError(f"{file}: {where}.{name}.unit = {shown(fields['unit'])} must be {METRICS[name].unit!r}")
        estimate = Estimate(**fields)
        if estimate.low is not None and estimate.high is not None and estimate.low > estimate.high:
            raise RecordError(f"{file}: {where}.{name}.low = {estimate.low} must not be above high = {estimate.high}")
        metrics[name] = estimate
    return metrics


def params_of(file: str, value: dict[str, Any]) -> tuple[Params, list[str]]:
    """The world, and the families that it draws from."""
    channels = value.get("channels")
    # A channel may elsewhere be the name of a file; here that would open a file of the record's choice.
    if (
        not isinstance(channels, list)
        or not 1 <= len(channels) <= CHANNELS_MAX
        or not all(isinstance(channel, dict) for channel in channels)
    ):
        raise RecordError(f"{file}: params.channels = {shown(channels)} must be a list of 1 to {CHANNELS_MAX} tables")
    try:
        params = from_dict(value)
        families = domain_of(params).families(params)
    except (ParamsError, TypeError, OverflowError) as error:
        raise RecordError(f"{file}: params: {error}") from error
    if isinstance(params, RoadParams) and params.road.config:  # highway-env imports what it names
        raise RecordError(
            f"{file}: params.road.config = {shown(params.road.config)} must be empty: a record's road is its scene's"
        )
    for group, whole in params.to_dict().items():
        if value.get(group) != whole:
            raise RecordError(f"{file}: params.{group} = {shown(value.get(group))} must hold all of {shown(whole)}")
    return params, families
