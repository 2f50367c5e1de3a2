"""One colour for each policy of a result, the same in the charts, the tables and the player."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle

from rss_gym.baselines import parse
from rss_gym.eval.evaluate import Result
from rss_gym.eval.report import curves
from rss_gym.eval.report.curves import Curve
from rss_gym.pages.colours import CLASSES, class_of

FAULT = "fault"  # the class of policies that are not ranked: red


@dataclass(frozen=True)
class Series:
    """The curves of a result, and a colour class for each policy."""

    curves: tuple[Curve, ...]
    classes: tuple[str, ...]


def of(result: Result) -> Series:
    """Policies of the package have their own colours, others the next free ones; the members of a curve share one."""
    entries = [scored.entry for scored in result.policies]
    specs = [entry.spec if entry.name == entry.spec else None for entry in entries]
    found = curves.find(specs)
    on_curve = {index for curve in found for index, _ in curve.members}
    own = [None if spec is None else class_of(spec) for spec in specs]
    free = cycle([class_ for class_ in CLASSES if class_ not in own] or CLASSES)
    given: dict[str, str] = {}
    classes = []
    for index, (entry, spec) in enumerate(zip(entries, specs, strict=True)):
        if result.policies[index].table["fault"].any():
            classes.append(FAULT)
            continue
        line = parse(spec).name if spec is not None and index in on_curve else f":{entry.name}"
        if line not in given:
            first = own[index]
            given[line] = next(free) if first is None or first in given.values() else first
        classes.append(given[line])
    return Series(tuple(found), tuple(classes))
