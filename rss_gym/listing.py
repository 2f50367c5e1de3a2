"""What there is to choose from, for `rss-gym list`."""

import dataclasses
from typing import Any

from rss_gym.baselines import describe, road
from rss_gym.encounters import FAMILIES, MIXED
from rss_gym.eval.suites import SUITES
from rss_gym.highway.scene import SCENES
from rss_gym.ids import IDS, ROADS
from rss_gym.meanings import MEANINGS
from rss_gym.params import CHANNELS, Channel, Params, kind_of
from rss_gym.ranging import ESTIMATORS
from rss_gym.tracking import TRACKERS
from rss_gym.train.recipe import load, recipes


def listing() -> dict[str, dict[str, str]]:
    """Title -> name -> one line."""
    return {
        "ids": {
            name: ", ".join(f"{k}={v!r}" for k, v in keywords.items()) or "default" for name, keywords in IDS.items()
        }
        | {name: f"highway-env: {SCENES[str(keywords['scene'])].summary}" for name, keywords in ROADS.items()},
        "policies": _described(describe()),
        "drivers": _described(describe(road.POLICIES, {})),
        "channels": {name: preset.summary for name, preset in CHANNELS.items()},
        "estimators": {
            name: f"{part.title}{'' if part.flies else ' [records only]'}" for name, part in ESTIMATORS.items()
        },
        "trackers": {
            name: f"{part.summary} [information {', '.join(part.information)}]" for name, part in TRACKERS.items()
        },
        "families": {MIXED: "all of these, by their weights"}
        | {name: f"{family.summary} [weight {family.weight:g}]" for name, family in FAMILIES.items()},
        "recipes": {name: f"{load(name).summary} [{load(name).steps} decisions]" for name in recipes()},
        "suites": {name: f"{suite.summary} [{suite.episodes} encounters]" for name, suite in SUITES.items()},
    }


def _described(policies: dict[str, dict[str, Any]]) -> dict[str, str]:
    return {
        name: item["summary"] + "".join(f" [{key}={value:g}]" for key, value in item["options"].items())
        for name, item in policies.items()
    }


UNITS = {
    "_mps2": "m/s^2", "_mps": "m/s", "_m2": "m^2", "_m": "m", "_s": "s", "_dbm": "dBm", "_db2": "dB^2", "_db": "dB",
}  # fmt: skip


def parameters(wanted: str = "") -> list[dict[str, Any]]:
    """Name, group, default, unit, range and meaning of the parameters with `wanted` in their name, group or meaning.

    Those of the group `channel` are the columns of a channel; the others are keywords of `gymnasium.make`.
    """
    found: list[dict[str, Any]] = []
    world = Params()
    groups = {item.name: getattr(world, item.name) for item in dataclasses.fields(world) if item.name != "channels"}
    for group, kind in [*groups.items(), ("channel", Channel())]:
        for item in dataclasses.fields(kind):
            row: dict[str, Any] = {
                "name": item.name,
                "group": group,
                "default": item.default,
                "unit": next((unit for end, unit in UNITS.items() if item.name.endswith(end)), ""),
                "range": _range(item),
                "meaning": MEANINGS[item.name],
            }
            if any(wanted.lower() in row[part].lower() for part in ("name", "group", "meaning")):
                found.append(row)
    return found


def _range(item: dataclasses.Field[Any]) -> str:
    """The values that a parameter may have."""
    kind = kind_of(item)
    if kind is not None and kind.known is not None:
        return ", ".join(kind.known())
    if "low" in item.metadata:
        return f"{item.metadata['low']:g} to {item.metadata['high']:g}"
    return "true, false" if isinstance(item.default, bool) else "see rss-gym list"
