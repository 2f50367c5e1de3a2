"""Policies behind one protocol, SB3's `predict`.

Scripted ones go by name; a new one is one file and one line in `POLICIES`. So do the learned ones that are shipped,
`AGENTS`; others go by their folder, `make("runs/ppo/agent", params)`. A name is a rule and, if wanted, the track it
flies on and options: `orca`, `orca@oracle:radius_m=30`; `cbf+NAME` is the control-barrier filter round the policy NAME.
On track `range` a rule that reads positions flies on those of the range-only filter.
"""

from __future__ import annotations

import dataclasses
import os
import re
from dataclasses import dataclass
from typing import Any, get_args

from rss_gym.baselines import shipped
from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.blind import Blind, Climb, Constant
from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.modified_orthogonal import ModifiedOrthogonal
from rss_gym.baselines.mpc import Mpc
from rss_gym.baselines.mvp import Mvp
from rss_gym.baselines.orca import Orca
from rss_gym.baselines.orthogonal import Orthogonal
from rss_gym.baselines.policy import Nothing, Policy, Random, Scripted
from rss_gym.baselines.policy_files import DOCUMENT
from rss_gym.baselines.range_only import RangeOnly
from rss_gym.baselines.reflexes import Brake, RightTurn
from rss_gym.baselines.shipped import AGENTS
from rss_gym.params import Params, ParamsError, Track, suggestion

__all__ = [
    "AGENTS",
    "POLICIES",
    "Parsed",
    "Policy",
    "able",
    "describe",
    "is_code",
    "is_folder",
    "is_known",
    "make",
    "parse",
]

PICKLED = (".zip", ".pkl", ".pt", ".pth")  # files whose reading runs code from them

POLICIES: dict[str, type[Scripted]] = {
    "none": Nothing,
    "orthogonal": Orthogonal,
    "modified-orthogonal": ModifiedOrthogonal,
    "orca": Orca,
    "mvp": Mvp,
    "cbf": Cbf,
    "mpc": Mpc,
    "constant": Constant,
    "climb": Climb,
    "blind": Blind,
    "brake": Brake,
    "right-turn": RightTurn,
    "random": Random,
}
RANGE = "range"  # the track without positions
FILTER = "cbf"  # the rule that may stand before a `+`


@dataclass(frozen=True)
class Parsed:
    """A policy's specification in its parts.

    Parameters
    ----------
    rule : str
        A name of `POLICIES` or `AGENTS`.
    track : str or None
        What stands after `@`.
    options : dict
        Those given.
    base : str or None
        The specification after `+`.
    """

    rule: str
    track: str | None
    options: dict[str, float]
    base: str | None

    @property
    def name(self) -> str:
        """The specification without this rule's options."""
        return self.rule + (f"@{self.track}" if self.track else "") + (f"+{self.base}" if self.base else "")


def is_known(spec: str) -> bool:
    """Whether the specification starts with a name of `POLICIES` or `AGENTS`."""
    name = re.split("[:@+]", spec, maxsplit=1)[0]
    return name in POLICIES or name in AGENTS


def is_folder(spec: str) -> bool:
    """Whether a specification is the folder of a learned policy; one that starts with a known name never is."""
    # os.path never raises for a name that is too long.
    return not is_known(spec) and os.path.isfile(os.path.join(spec, DOCUMENT))


def is_code(spec: str) -> bool:
    """Whether a specification is `module:attribute`, which runs code of that module."""
    return ":" in spec and not is_known(spec) and not is_folder(spec) and not spec.endswith(PICKLED)


def parse(spec: str) -> Parsed:
    """Take apart `rule`, `rule@track`, `rule:option=value,option=value`, `cbf+NAME`, and what these combine to.

    Raises
    ------
    ParamsError
        For an unknown name, track or option, an option given twice, or a value that is not a number.
    """
    own, _, base = re.sub(r"(?<!=)\+(?=[A-Za-z./])", "\n", spec, count=1).partition("\n")  # not that of 1e+2
    head, _, text = own.partition(":")
    rule, at, track = head.partition("@")
    if rule not in POLICIES and rule not in AGENTS:
        raise ParamsError(f"policy {rule!r} is unknown{suggestion(rule, [*POLICIES, *AGENTS])}")
    if at and track not in get_args(Track):
        raise ParamsError(f"policy {spec!r}: track {track!r} is unknown{suggestion(track, get_args(Track))}")
    if base and (rule != FILTER or at):
        raise ParamsError(f"policy {spec!r}: only {FILTER!r} goes round another policy, and flies on the track of that")
    known, options = list(_options(POLICIES[rule])) if rule in POLICIES else [], dict[str, float]()
    for item in filter(None, text.split(",")):
        key, equals, value = item.partition("=")
        key = key.strip()
        if key not in known:
            hint = suggestion(key, known) if known else "; it has none"
            raise ParamsError(f"policy {rule!r} has no option {key!r}{hint}")
        if key in options:
            raise ParamsError(f"option {key!r} of policy {rule!r} is given twice")
        try:
            options[key] = float(value)
        except ValueError:
            raise ParamsError(f"option {key!r} of policy {rule!r} must be a number, got {value!r}") from None
        if not equals:
            raise ParamsError(f"option {key!r} of policy {rule!r} has no value; write {key}=number")
    return Parsed(rule, track or None, options, base or None)


def make(spec: str, params: Params | None = None) -> Scripted | Agent:
    """The policy that a specification describes (see `parse`), or that lies in a folder.

    Parameters
    ----------
    spec : str
        Names of `POLICIES` with tracks and options, all numbers in SI; a name of `AGENTS`; or a folder with
        `policy.json`.
    params : Params, optional
        The world; the policy's own `world` is this with the interface that the policy declares. Without `@track` it
        flies on the world's track if it can.

    Raises
    ------
    ParamsError
        For what `parse` or `rss_gym.baselines.agent.load` refuses, an option out of range, a track or a plane that the
        policy cannot fly in, or a contradiction with the world.
    """
    if is_folder(spec):
        return load(spec, params)
    if spec.endswith(PICKLED):
        raise ParamsError(
            f"policy {spec!r} is a file whose reading runs code from it: make a policy folder of it with "
            "`rss-gym export` and name that"
        )
    parsed = parse(spec)
    if parsed.rule in AGENTS:
        return shipped.make(parsed.rule, params, parsed.track)
    kind, world = POLICIES[parsed.rule], Params.of(params)
    base = make(parsed.base, world) if parsed.base else None
    track = parsed.track or (base.world if base else world).interface.track
    # The range-only filter hands a rule positions, but not the actions of another policy.
    tracks = tuple(name for name in kind.tracks if not (base and name == RANGE))
    if track not in tracks:
        if parsed.track or base:
            raise ParamsError(
                f"policy {spec!r}: {parsed.rule!r} cannot fly on track {track!r}, where it is not told what it needs; "
                f"it can on {', '.join(tracks)}"
            )
        track = tracks[-1]
    if kind.in_space and world.encounter.planar:
        raise ParamsError(f"policy {spec!r}: {parsed.rule!r} flies in space only, got a world with planar = True")
    try:
        options: dict[str, Any] = parsed.options | ({"base": base} if base else {})
        policy: Scripted = kind(world=world, **options)
        if track == RANGE and policy.reads_positions:
            policy = RangeOnly(world=world, rule=policy)
        return dataclasses.replace(policy, world=Params.of(world, track=track, **policy.interface()))
    except ParamsError as error:
        raise ParamsError(f"policy {spec!r}: {error}") from error


def _options(kind: type[Scripted]) -> dict[str, Any]:
    """Name -> default of the options that a specification may set: the numbers."""
    return {f.name: f.default for f in dataclasses.fields(kind) if "low" in f.metadata}


def able(world: Params) -> list[str]:
    """Names of all that can fly in this world, on its track, at their defaults."""
    track, planar = world.interface.track, world.encounter.planar
    rules = [name for name, kind in POLICIES.items() if track in kind.tracks and not (kind.in_space and planar)]
    return rules + [name for name in AGENTS if shipped.fits(name, world)]


def describe() -> dict[str, dict[str, Any]]:
    """Name -> summary and options with their defaults, for listings."""
    rules = {
        name: {"summary": (kind.__doc__ or "").strip().splitlines()[0], "options": _options(kind)}
        for name, kind in POLICIES.items()
    }
    return rules | {name: {"summary": shipped.summary(folder), "options": {}} for name, folder in AGENTS.items()}
