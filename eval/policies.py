"""What the evaluator accepts as a policy, by name, by `module:attribute`, or as an object."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rss_gym import baselines
from rss_gym.baselines import policy_files
from rss_gym.baselines.agent import Agent
from rss_gym.baselines.policy import Scripted
from rss_gym.domain import domain_of
from rss_gym.eval.imported import imported
from rss_gym.eval.normalised import with_statistics
from rss_gym.params import Params, ParamsError


@dataclass(frozen=True)
class Entry:
    """A policy to score: its name in tables, how to build it again, and the world it flies in."""

    name: str
    spec: str
    policy: Any
    params: Params

    @property
    def action(self) -> str | None:
        """What it commands; None where nothing tells."""
        return self.params.interface.action

    @property
    def hash(self) -> str:
        """SHA-256 of the specification, for a learned policy of its files, and of the interface it flies with."""
        text = json.dumps([identity(self.spec, self.policy), self.params.interface.to_dict()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def identity(spec: str, policy: Any) -> str:
    """The specification with a learned policy's digest in place of its folder or name, alone or inside `cbf+`."""
    if isinstance(policy, Agent):
        return policy.digest
    inside = baselines.parse(spec).base if baselines.is_known(spec) else None
    return spec if inside is None else spec.removesuffix(inside) + identity(inside, policy.base)


def entry(policy: Any, params: Params, name: str | None = None) -> Entry:
    """The policy as an `Entry` of a world.

    Parameters
    ----------
    policy : str, path or object
        A name of `rss_gym.baselines.POLICIES` with options or of `AGENTS`, the folder of a learned policy,
        `module:attribute` or `file.py:attribute` (see `rss_gym.eval.imported`), or an object with `predict`.
    params : Params
        The suite's world.

    Raises
    ------
    ParamsError
        For an unknown name, a module or attribute that cannot be imported, a folder without an intact policy, an object
        without `predict`, or a policy that needs another level of information.
    """
    if isinstance(policy, os.PathLike):
        policy = os.path.join(os.curdir, policy)  # a path is never the name of a policy
    spec = policy if isinstance(policy, str) else f"{type(policy).__module__}.{type(policy).__qualname__}"
    if isinstance(policy, str):
        if name is None and baselines.is_folder(policy):
            name = folder_name(policy)
        policy = imported(policy, params) if baselines.is_code(policy) else baselines.make(policy, params)
    policy = with_statistics(policy)
    if not callable(getattr(policy, "predict", None)):
        raise ParamsError(f"policy {spec!r} has no method `predict`; it must follow SB3's protocol")
    if isinstance(policy, (Scripted, Agent)):
        flown = policy.params
        needed, given = flown.interface.information, params.interface.information
        if domain_of(flown) is not domain_of(params):
            kinds = f"{domain_of(flown).name}, and the suite is one of the {domain_of(params).name}"
            raise ParamsError(f"policy {spec!r} is made for the {kinds}")
        if needed not in (given, "oracle"):
            raise ParamsError(f"policy {spec!r} needs information {needed!r}, but the suite gives {given!r}")
        params = flown
    return Entry(name or spec, spec, policy, params)


def innermost(spec: str) -> str:
    """The policy inside all filters `cbf+`, the whole specification if there is none.

    Raises
    ------
    ParamsError
        As `rss_gym.baselines.parse`.
    """
    while baselines.is_known(spec) and (base := baselines.parse(spec).base):
        spec = base
    return spec


def files(item: Entry) -> tuple[bytes, bytes] | None:
    """The two files of a learned policy that was given by its folder, alone or inside `cbf+`.

    None for any other policy, and where the files are not those any more that the policy was made of.
    """
    if not isinstance(item.policy, (Agent, Scripted)):
        return None
    folder, policy = baselines.folder_of(innermost(item.spec)), item.policy
    while isinstance(policy, Scripted) and hasattr(policy, "base"):
        policy = policy.base
    if folder is None or not isinstance(policy, Agent):
        return None
    try:
        found = policy_files.read(Path(folder))
    except ParamsError:
        return None
    return found if hashlib.sha256(b"".join(found)).hexdigest() == policy.digest else None


def folder_name(spec: str) -> str:
    """The last part of the path that says more than where a run keeps its agent."""
    path = Path(spec).resolve()
    return path.parent.name if path.name == "agent" and path.parent.name else path.name
