"""One colour a rule, the same in the charts, the tables and the player."""

from __future__ import annotations

from dataclasses import dataclass

from rss_gym.baselines import parse
from rss_gym.eval.evaluate import NOMINAL, Result
from rss_gym.eval.report import curves
from rss_gym.eval.report.curves import Curve

FAULT = "fault"  # the class of policies that are not ranked: red
COLOURS = 8  # classes c0 ... of the style sheet, used again from the first


@dataclass(frozen=True)
class Series:
    """The curves of a result, and a colour class for each policy."""

    curves: tuple[Curve, ...]
    classes: tuple[str, ...]


def of(result: Result) -> Series:
    """Colours in the order of the policies; all members of a rule's curves share one."""
    entries = [scored.entry for scored in result.policies]
    specs = [entry.spec if entry.name == entry.spec else None for entry in entries]
    found = curves.find(specs)
    on_curve = {index for curve in found for index, _ in curve.members}
    colours: dict[str, str] = {}
    classes = []
    for index, (entry, spec) in enumerate(zip(entries, specs, strict=True)):
        if result.policies[index].table["fault"].any():
            classes.append(FAULT)
            continue
        if entry.name == NOMINAL:
            classes.append("nominal")
            continue
        rule = parse(spec).name if spec is not None and index in on_curve else f":{entry.name}"
        classes.append(colours.setdefault(rule, f"c{len(colours) % COLOURS}"))
    return Series(tuple(found), tuple(classes))
