"""Which policies are one rule at several settings: `orthogonal:radius_m=20`, `orthogonal:radius_m=40`, ... are a curve.

A curve belongs to a name and the options that stay the same; the option that varies orders its members.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rss_gym import baselines
from rss_gym.params import ParamsError


@dataclass(frozen=True)
class Curve:
    """One rule over one of its options.

    Parameters
    ----------
    label : str
        Rule, the option that varies, and the others where the rule has several curves.
    short : str
        Rule and option.
    option : str
        What varies.
    members : tuple of (int, float)
        Index of the policy and value of the option, in rising order of the value.
    """

    label: str
    short: str
    option: str
    members: tuple[tuple[int, float], ...]


def parsed(spec: str) -> tuple[str, dict[str, float]] | None:
    """Name and options of a scripted policy, defaults included; None for anything else."""
    try:
        found = baselines.parse(spec)
    except ParamsError:
        return None
    defaults = baselines.describe({**baselines.road.POLICIES, **baselines.POLICIES})[found.rule]["options"]
    return found.name, {key: float(value) for key, value in (defaults | found.options).items()}


def find(specs: Sequence[str | None]) -> list[Curve]:
    """The curves among policies; None stands for a policy that has a name of its own and stays alone."""
    rules: dict[str, dict[int, dict[str, float]]] = {}
    for index, spec in enumerate(specs):
        if spec is not None and (found := parsed(spec)) is not None:
            rules.setdefault(found[0], {})[index] = found[1]
    return [curve for name, members in rules.items() for curve in _of_rule(name, members)]


def _of_rule(name: str, members: dict[int, dict[str, float]]) -> list[Curve]:
    """Curves over the option with the most values, then over the others for the members that are on none yet."""
    options = next(iter(members.values()))
    varying = [key for key in options if len({values[key] for values in members.values()}) > 1]
    groups, joined = [], set[int]()
    for key in sorted(varying, key=lambda key: -len({values[key] for values in members.values()})):
        alike: dict[tuple[float, ...], list[int]] = {}
        for index, values in members.items():
            alike.setdefault(tuple(value for other, value in values.items() if other != key), []).append(index)
        for group in alike.values():
            if len(group) > 1 and not joined.issuperset(group):
                groups.append((key, sorted(group, key=lambda index: members[index][key])))
                joined.update(group)
    curves = []
    for key, group in groups:
        fixed = [f"{other} = {members[group[0]][other]:g}" for other in varying if other != key]
        label = ", ".join([f"{name} over {key}", *(fixed if len(groups) > 1 else [])])
        curves.append(Curve(label, f"{name}, {key}", key, tuple((index, members[index][key]) for index in group)))
    return curves
