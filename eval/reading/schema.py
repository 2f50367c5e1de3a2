"""The fields of `scores.json`, what each may hold, and what is made of the larger ones."""

from __future__ import annotations

from typing import Any, get_args

from rss_gym.core import SEED_LIMIT, SPLITS
from rss_gym.domain import domain_of, from_dict
from rss_gym.eval.evaluate import NAME_MAX, is_name
from rss_gym.eval.metrics import METRICS, Estimate, defined_in
from rss_gym.eval.reading.plain import RecordError, checked
from rss_gym.eval.reading.table_file import EPISODES_MAX
from rss_gym.eval.records import POLICIES, SCHEMA, TABLES
from rss_gym.highway.params import RoadParams
from rss_gym.params import ActionKind, Information, Params, ParamsError
from rss_gym.schema import (
    HEX,
    Kind,
    Schema,
    line,
    listed,
    matching,
    one_of,
    optional,
    real,
    refuse_unknown,
    shown,
    table,
    truth,
    version,
    whole,
)

POLICIES_MAX = 1000
CHANNELS_MAX = 64
SPEC_MAX = 1000
WITHOUT_ACTION = 3  # an older schema, whose policies do not say what they command


_NAME = Kind(is_name, f"1 to {NAME_MAX} printable characters")
_TEXT = line(SPEC_MAX, 0)
_NUMBER = optional(real(), "a finite number or null")
_SEED = whole(0, SEED_LIMIT - 1, "a whole number in [0, 2**63)")


def _is_versions(value: Any) -> bool:
    few = isinstance(value, dict) and len(value) <= 100
    return few and all(is_name(key) and is_name(text) for key, text in value.items())


RECORD: Schema = {
    "schema": version(WITHOUT_ACTION, SCHEMA),
    "suite": _NAME,
    "suite_hash": HEX,
    "split": one_of(SPLITS),
    "seed": _SEED,
    "episodes": whole(1, EPISODES_MAX),
    "first_episode": _SEED,
    "official": truth(),
    "reference": _NAME,
    "families": listed(0, 10**6, "a list of families"),
    "params": table("a table of parameters"),
    "versions": Kind(_is_versions, "a table of package names and versions"),
    "policies": listed(1, POLICIES_MAX, f"a list of 1 to {POLICIES_MAX} policies"),
}
POLICY: Schema = {
    "name": _NAME,
    "spec": _TEXT,
    "hash": HEX,
    "information": one_of(get_args(Information)),
    "action": one_of(get_args(ActionKind)),
    "metrics": table("a table of metrics"),
    "table": matching(TABLES + r"/[0-9]{2,4}-[A-Za-z0-9.=_-]{0,80}\.npz", f"a file such as {TABLES}/00-none.npz"),
    "table_sha256": HEX,
    "folder": optional(
        matching(POLICIES + r"/[0-9]{2,4}-[A-Za-z0-9.=_-]{0,80}", f"a folder such as {POLICIES}/01-mine")
    ),
}
POLICIES_OF: dict[int, Schema] = {
    WITHOUT_ACTION: {name: check for name, check in POLICY.items() if name != "action"},
    SCHEMA: POLICY,
}
ESTIMATE: Schema = {
    "value": _NUMBER,
    "low": _NUMBER,
    "high": _NUMBER,
    "n": whole(0, SEED_LIMIT - 1, "a whole number >= 0"),
    "unit": _TEXT,
}


def metrics_of(file: str, where: str, value: dict[str, Any], domain: str = "air") -> dict[str, Estimate]:
    """The metrics of a policy."""
    refuse_unknown(file, where, value, defined_in(domain), RecordError)
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
    for group, every in params.to_dict().items():
        if value.get(group) != every:
            raise RecordError(f"{file}: params.{group} = {shown(value.get(group))} must hold all of {shown(every)}")
    return params, families
