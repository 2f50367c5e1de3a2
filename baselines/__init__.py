"""Policies behind one protocol, SB3's `predict`.

Scripted ones go by name, `make("orthogonal:radius_m=60", params)`, learned ones by their folder,
`make("runs/ppo/agent", params)`. A new scripted policy is one file and one line in `POLICIES`.
"""

from __future__ import annotations

import dataclasses
import os
from typing import Any

from rss_gym.baselines.agent import DOCUMENT, Agent, load
from rss_gym.baselines.blind import Blind, Constant
from rss_gym.baselines.modified_orthogonal import ModifiedOrthogonal
from rss_gym.baselines.orthogonal import Orthogonal, OrthogonalOracle
from rss_gym.baselines.policy import Nothing, Policy, Random, Scripted
from rss_gym.baselines.reflexes import Brake, RightTurn
from rss_gym.params import Params, ParamsError, suggestion

__all__ = ["POLICIES", "Policy", "describe", "is_code", "is_folder", "make"]

PICKLED = (".zip", ".pkl", ".pt", ".pth")  # files whose reading runs code from them

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


def is_folder(spec: str) -> bool:
    """Whether a specification is the folder of a learned policy; a name of `POLICIES` never is."""
    # os.path never raises for a name that is too long.
    return spec.partition(":")[0] not in POLICIES and os.path.isfile(os.path.join(spec, DOCUMENT))


def is_code(spec: str) -> bool:
    """Whether a specification is `module:attribute`, which runs code of that module."""
    name, colon, _ = spec.partition(":")
    return bool(colon) and name not in POLICIES and not is_folder(spec) and not spec.endswith(PICKLED)


def make(spec: str, params: Params | None = None) -> Scripted | Agent:
    """The policy that `name`, `name:option=value,option=value` or a folder describes.

    Parameters
    ----------
    spec : str
        A name of `POLICIES` with options, all numbers in SI; or a folder with `policy.json`.
    params : Params, optional
        The world; the policy's own `world` is this with the interface that the policy declares.

    Raises
    ------
    ParamsError
        For an unknown name or option, a value that is not a number or out of range, a contradiction with the world, or
        a folder that `rss_gym.baselines.agent.load` refuses.
    """
    name, _, text = spec.partition(":")
    if is_folder(spec):
        return load(spec, params)
    if spec.endswith(PICKLED):
        raise ParamsError(
            f"policy {spec!r} is a file whose reading runs code from it: make a policy folder of it with "
            "`rss-gym export` and name that"
        )
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
