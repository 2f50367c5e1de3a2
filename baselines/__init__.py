"""Policies behind one protocol, SB3's `predict`.

Scripted ones go by name; a new one is one file and one line in `POLICIES`, or `rss_gym.register_rule`. So do the
learned ones that are shipped, `AGENTS`; others go by their folder, `make("runs/ppo/agent", params)`. A name is a rule
and, if wanted, the level of information it flies on and options: `orca`, `orca@oracle:radius_m=30`; `cbf+NAME` is the
control-barrier filter round the policy NAME. A policy flies in the world that it is made for, and in no world of
another level.
"""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from rss_gym.baselines import road, shipped
from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.blind import Back, Blind, Climb, Constant, Stop, Velocity
from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.modified_orthogonal import ModifiedOrthogonal
from rss_gym.baselines.mpc import Mpc
from rss_gym.baselines.mvp import Mvp
from rss_gym.baselines.orca import Orca
from rss_gym.baselines.orthogonal import Orthogonal
from rss_gym.baselines.policy import Nothing, Policy, Random, Scripted
from rss_gym.baselines.policy_files import DOCUMENT
from rss_gym.baselines.qmdp import Qmdp
from rss_gym.baselines.reflexes import Brake, RightTurn
from rss_gym.baselines.shipped import AGENTS
from rss_gym.domain import AIR, ROAD, domain_of
from rss_gym.params import Information, Params, ParamsError, Tracking, suggestion
from rss_gym.registry import Registry

__all__ = [
    "AGENTS",
    "POLICIES",
    "Parsed",
    "Policy",
    "able",
    "describe",
    "folder_of",
    "informed",
    "is_code",
    "is_folder",
    "is_known",
    "make",
    "parse",
    "policies",
]

RUN_AGENT = "agent"  # where a run keeps its policy
PICKLED = (".zip", ".pkl", ".pt", ".pth")  # files whose reading runs code from them

_SHIPPED: dict[str, type[Scripted]] = {
    "none": Nothing,
    "orthogonal": Orthogonal,
    "modified-orthogonal": ModifiedOrthogonal,
    "orca": Orca,
    "mvp": Mvp,
    "cbf": Cbf,
    "mpc": Mpc,
    "qmdp": Qmdp,
    "constant": Constant,
    "velocity": Velocity,
    "climb": Climb,
    "stop": Stop,
    "back": Back,
    "blind": Blind,
    "brake": Brake,
    "right-turn": RightTurn,
    "random": Random,
}
LEVELS = get_args(Information)


def _check(name: str, rule: type[Scripted]) -> None:
    if not isinstance(rule, type) or not issubclass(rule, Scripted) or not dataclasses.is_dataclass(rule):
        raise ParamsError(
            f"rule {name!r} must be a frozen dataclass derived from rss_gym.baselines.policy.Scripted, got {rule!r}"
        )
    if rule.act is Scripted.act:
        raise ParamsError(f"rule {name!r}: {rule.__name__} must have a method act(seen, memory)")
    if not (rule.__doc__ or "").strip() or (rule.__doc__ or "").startswith(f"{rule.__name__}("):
        raise ParamsError(f"rule {name!r}: {rule.__name__} must have a docstring, whose first line is its summary")
    if name in AGENTS:
        raise ParamsError(f"rule {name!r} has the name of a shipped agent; give it another")


POLICIES: Registry[type[Scripted]] = Registry("rule", _SHIPPED, _check, like="my-rule")
FILTER = "cbf"  # the rule that may stand before a `+`


@dataclass(frozen=True)
class Parsed:
    """A policy's specification in its parts.

    Parameters
    ----------
    rule : str
        A name of `POLICIES` or `AGENTS`.
    information : str or None
        What stands after `@`.
    options : dict
        Those given.
    base : str or None
        The specification after `+`.
    """

    rule: str
    information: str | None
    options: dict[str, float]
    base: str | None

    @property
    def name(self) -> str:
        """The specification without this rule's options."""
        return self.rule + (f"@{self.information}" if self.information else "") + (f"+{self.base}" if self.base else "")


def policies(params: Params) -> Mapping[str, type[Scripted]]:
    """The scripted policies of a world's domain."""
    return road.POLICIES if domain_of(params) is ROAD else POLICIES


def is_known(spec: str) -> bool:
    """Whether the specification starts with a name of a scripted policy or of `AGENTS`."""
    name = re.split("[:@+]", spec, maxsplit=1)[0]
    return name in POLICIES or name in road.POLICIES or name in AGENTS


def is_folder(spec: str) -> bool:
    """Whether a specification is the folder of a learned policy, or of a run that has one; a known name never is."""
    return folder_of(spec) is not None


def folder_of(spec: str) -> str | None:
    """The folder of the learned policy: the one that is named, or `agent` in the folder of a run."""
    if is_known(spec):
        return None
    # os.path never raises for a name that is too long.
    return next(
        (path for path in (spec, os.path.join(spec, RUN_AGENT)) if os.path.isfile(os.path.join(path, DOCUMENT))), None
    )


def is_code(spec: str) -> bool:
    """Whether a specification is `module:attribute`, which runs code of that module."""
    return ":" in spec and not is_known(spec) and not is_folder(spec) and not spec.endswith(PICKLED)


def parse(spec: str, params: Params | None = None) -> Parsed:
    """Take apart `rule`, `rule@information`, `rule:option=value,option=value`, `cbf+NAME`, and what these combine to.

    The names are those of the world's domain, or, without a world, of both.

    Raises
    ------
    ParamsError
        For an unknown name, level of information or option, an option given twice, or a value that is not a number.
    """
    own, _, base = re.sub(r"(?<!=)\+(?=[A-Za-z./])", "\n", spec, count=1).partition("\n")  # not that of 1e+2
    head, _, text = own.partition(":")
    rule, at, information = head.partition("@")
    kinds = {**road.POLICIES, **POLICIES} if params is None else policies(params)
    if rule not in kinds and rule not in AGENTS:
        if os.sep in rule or os.path.lexists(rule):
            raise ParamsError(
                f"policy {rule!r} is unknown: {_no_policy(rule)}; a learned policy is a folder with {DOCUMENT}"
            )
        where = " on a road" if kinds is road.POLICIES else ""
        raise ParamsError(f"policy {rule!r} is unknown{where}{suggestion(rule, [*kinds, *AGENTS])}")
    if at and information not in LEVELS:
        raise ParamsError(f"policy {spec!r}: information {information!r} is unknown{suggestion(information, LEVELS)}")
    if base and (rule != FILTER or at):
        raise ParamsError(
            f"policy {spec!r}: only {FILTER!r} goes round another policy, and flies on the information of that"
        )
    known, options = list(_options(kinds[rule])) if rule in kinds else [], dict[str, float]()
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
    return Parsed(rule, information or None, options, base or None)


def _no_policy(path: str) -> str:
    """What is at a path where a policy was looked for."""
    if os.path.isdir(path):
        return f"a folder without {DOCUMENT} or {os.path.join(RUN_AGENT, DOCUMENT)}"
    if os.path.exists(path):
        return "a file"
    return "a link to nothing" if os.path.islink(path) else "no folder of that name"


def make(spec: str, params: Params | None = None) -> Scripted | Agent:
    """The policy that a specification describes (see `parse`), or that lies in a folder.

    Parameters
    ----------
    spec : str
        Names of `POLICIES` with levels of information and options, all numbers in SI; a name of `AGENTS`; or a folder
        with `policy.json`.
    params : Params, optional
        The world that the policy will fly in, the default one if not given. The policy's own `params` are these with
        velocities for actions and, if the specification names one after `@`, with that level of information.

    Raises
    ------
    ParamsError
        For what `parse` or `rss_gym.baselines.agent.load` refuses, an option out of range, a level of information or a
        plane that the policy cannot fly on or in, or a contradiction with the world.
    """
    flown = Params.of(action="velocity") if params is None else domain_of(params).commanded(params)
    folder = folder_of(spec)
    if folder is not None:
        return load(folder, None if params is None else flown)
    if spec.endswith(PICKLED):
        raise ParamsError(
            f"policy {spec!r} is a file whose reading runs code from it: make a policy folder of it with "
            "`rss-gym export` and name that"
        )
    parsed = parse(spec, flown)
    if parsed.information:
        flown = informed(flown, parsed.information)
    if parsed.rule in AGENTS:
        return load(AGENTS[parsed.rule], flown, f"policy {spec!r}, trained in {shipped.home(parsed.rule)}")
    kind = policies(flown)[parsed.rule]
    flown = kind.home(flown)
    base = make(parsed.base, flown) if parsed.base else None
    if base:
        flown = base.params
    level = flown.interface.information
    if level not in kind.information:
        raise ParamsError(
            f"policy {spec!r} cannot fly on information {level!r}: {parsed.rule!r} is for "
            f"{', '.join(map(repr, kind.information))}"
        )
    if kind.in_space and flown.encounter.planar:
        raise ParamsError(f"policy {spec!r}: {parsed.rule!r} flies in space only, got a world with planar = True")
    try:
        options: dict[str, Any] = parsed.options | ({"base": base} if base else {})
        return kind(params=flown, **options)
    except ParamsError as error:
        raise ParamsError(f"policy {spec!r}: {error}") from error


def informed(params: Params, information: str) -> Params:
    """The world with another level of information: of the trackers, `bearings` is for `ranges` and no other level."""
    keywords: dict[str, Any] = {"information": information}
    if domain_of(params) is AIR and "ranges" == params.interface.information != information:
        keywords["tracker"] = Tracking().tracker
    return Params.of(params, **keywords)


def _options(kind: type[Scripted]) -> dict[str, Any]:
    """Name -> default of the options that a specification may set: the numbers."""
    return {f.name: f.default for f in dataclasses.fields(kind) if "low" in f.metadata}


def able(params: Params) -> list[str]:
    """Names of all policies that can fly in this world, on its level of information, with their default options."""
    found = []
    for name, kind in policies(params).items():
        level = kind.home(params).interface.information
        if level in kind.information and not (kind.in_space and params.encounter.planar):
            found.append(name)
    return found + [name for name in AGENTS if shipped.fits(name, params)]


def describe(
    kinds: Mapping[str, type[Scripted]] = POLICIES, agents: Mapping[str, Path] = AGENTS
) -> dict[str, dict[str, Any]]:
    """Name -> summary and options with their defaults, for listings."""
    rules = {
        name: {"summary": (kind.__doc__ or "").strip().splitlines()[0], "options": _options(kind)}
        for name, kind in kinds.items()
    }
    return rules | {name: {"summary": shipped.summary(folder), "options": {}} for name, folder in agents.items()}
