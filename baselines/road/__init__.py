"""Policies on the roads of highway-env, behind SB3's `predict`; a new one is one file and one line in `POLICIES`."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from rss_gym.baselines import PICKLED, folder_of, shipped
from rss_gym.baselines.road.agent import RoadAgent, load
from rss_gym.baselines.road.policy import Driver, Idm, Nothing, World
from rss_gym.baselines.road.rule import Rule
from rss_gym.params import ParamsError, suggestion

__all__ = ["AGENTS", "POLICIES", "World", "describe", "make"]

POLICIES: dict[str, type[Driver]] = {"none": Nothing, "rule": Rule, "idm": Idm}
FOLDER = Path(__file__).parent / "agents"
AGENTS = shipped.found(FOLDER)  # learned ones: name -> policy folder


def make(spec: str, world: World) -> Driver | RoadAgent:
    """The policy that a specification describes.

    Parameters
    ----------
    spec : str
        A name of `POLICIES`, with options as in `rule:lateral_m=2`, one of `AGENTS`, or the folder of a learned policy.
    world : World
        The road it drives on.

    Raises
    ------
    ParamsError
        For an unknown name or option, with the nearest known one, a value out of range, or what
        `rss_gym.baselines.road.agent.load` refuses.
    """
    name, _, text = spec.partition(":")
    if name in AGENTS:
        if text:
            raise ParamsError(f"policy {spec!r}: {name!r} is learned and has no options")
        return load(AGENTS[name], world, f"policy {name!r}")
    if name not in POLICIES:
        folder = folder_of(spec)
        if folder is not None:
            return load(folder, world)
        if spec.endswith(PICKLED):
            raise ParamsError(f"policy {spec!r} is a file whose reading runs code from it; name a policy folder")
        raise ParamsError(f"policy {name!r} is unknown on a road{suggestion(name, [*POLICIES, *AGENTS])}")
    options: dict[str, Any] = {}
    for item in filter(None, text.split(",")):
        key, _, value = item.partition("=")
        try:
            options[key] = float(value)
        except ValueError:
            raise ParamsError(f"policy {spec!r}: option {key!r} must be a number, got {value!r}") from None
    try:
        return POLICIES[name](world=world).replace(**options)
    except ParamsError as error:
        raise ParamsError(f"policy {spec!r}: {error}") from error


def describe() -> dict[str, str]:
    """Name -> summary and options with their defaults, for listings."""
    found = {}
    for name, kind in POLICIES.items():
        options = [f" [{f.name}={f.default:g}]" for f in dataclasses.fields(kind) if "low" in f.metadata]
        found[name] = (kind.__doc__ or "").strip().splitlines()[0] + "".join(options)
    return found | {name: shipped.summary(folder) for name, folder in AGENTS.items()}
