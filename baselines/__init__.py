"""Policies behind one protocol, SB3's `predict`, by name: `make("orthogonal:radius_m=60", params)`.

A new policy is one file and one line in `POLICIES`.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from rss_gym.baselines.blind import Blind, Constant
from rss_gym.baselines.modified_orthogonal import ModifiedOrthogonal
from rss_gym.baselines.orthogonal import Orthogonal, OrthogonalOracle
from rss_gym.baselines.policy import Nothing, Policy, Random, Scripted
from rss_gym.baselines.reflexes import Brake, RightTurn
from rss_gym.params import Params, ParamsError, suggestion

__all__ = ["POLICIES", "Policy", "describe", "make"]

POLICIES: dict[str, type[Scripted]] = {
    "none": Nothing,
    "orthogonal": Orthogonal,
    "orthogonal-oracle": OrthogonalOracle,
    "modified-orthogonal": ModifiedOrthogonal,
    "constant": Constant,
    "blind": Blind,
    "brake": Brake,
    "right-turn": RightTurn,
    "random": Random,
}


def make(spec: str, params: Params | None = None) -> Scripted:
    """The policy that `name` or `name:option=value,option=value` describes.

    Parameters
    ----------
    spec : str
        A name of `POLICIES` with options, all numbers in SI.
    params : Params, optional
        The world; the policy's own `world` is this with the interface that the policy declares.

    Raises
    ------
    ParamsError
        For an unknown name or option, a value that is not a number or out of range, or a contradiction with the world.
    """
    name, _, text = spec.partition(":")
    if name not in POLICIES:
        raise ParamsError(f"policy {name!r} is unknown{suggestion(name, POLICIES)}")
    kind = POLICIES[name]
    known = [f.name for f in dataclasses.fields(kind) if f.name != "world"]
    options: dict[str, Any] = {}
    for item in filter(None, text.split(",")):
        key, equals, value = item.partition("=")
        key = key.strip()
        if key not in known:
            hint = suggestion(key, known) if known else "; it has none"
            raise ParamsError(f"policy {name!r} has no option {key!r}{hint}")
        try:
            options[key] = float(value)
        except ValueError:
            raise ParamsError(f"option {key!r} of policy {name!r} must be a number, got {value!r}") from None
        if not equals:
            raise ParamsError(f"option {key!r} of policy {name!r} has no value; write {key}=number")
    try:
        policy = kind(**options)
        return dataclasses.replace(policy, world=Params.of(params, **policy.interface()))
    except ParamsError as error:
        raise ParamsError(f"policy {spec!r}: {error}") from error


def describe() -> dict[str, dict[str, Any]]:
    """Name -> summary and options with their defaults, for listings."""
    return {
        name: {
            "summary": (kind.__doc__ or "").strip().splitlines()[0],
            "options": {f.name: f.default for f in dataclasses.fields(kind) if f.name != "world"},
        }
        for name, kind in POLICIES.items()
    }
