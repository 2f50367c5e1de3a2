"""Collisions in each family of encounters, as a table whose shades follow the logarithm of the rate."""

from __future__ import annotations

import math

import numpy as np

from rss_gym.eval.evaluate import Result
from rss_gym.eval.intervals import Interval, clopper_pearson
from rss_gym.eval.report import series
from rss_gym.eval.report.numbers import number
from rss_gym.eval.report.tables import policy_heading, scrolled
from rss_gym.pages.page import text

FAINTEST = -4.0  # power of ten that gets no shade


def rates(result: Result) -> list[list[Interval]]:
    """Collision rate of each policy (rows) in each family of the suite (columns), with exact intervals."""
    out = []
    for scored in result.policies:
        family, collision = scored.table["family"], scored.table["collision"]
        members = [family == index for index in range(len(result.suite.families))]
        out.append([clopper_pearson(int(np.count_nonzero(collision[m])), int(np.count_nonzero(m))) for m in members])
    return out


def shade(rate: float) -> float:
    """From 0 for rare to 1 for certain."""
    return min(1.0, max(0.0, 1.0 - math.log10(rate) / FAINTEST)) if rate > 0.0 else 0.0


def breakdown(result: Result) -> str:
    """The table."""
    table = rates(result)
    counts = [interval.n for interval in table[0]]
    headings = '<th scope="col">policy</th>' + "".join(
        f'<th scope="col">{text(name)} <span class="unit">n = {count:,}</span></th>'
        for name, count in zip(result.suite.families, counts, strict=True)
    )
    rows = ""
    for scored, class_, row in zip(result.policies, series.of(result).classes, table, strict=True):
        rows += f"<tr>{policy_heading(scored.entry.name, class_)}{''.join(map(_cell, row))}</tr>\n"
    return scrolled(
        f'<table class="heat sortable"><thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody></table>'
    ) + (
        '<p class="note">Collisions per encounter of the family, with exact 95 % intervals; the stronger the '
        "colour, the higher the rate, on a logarithmic scale.</p>"
    )


def _cell(rate: Interval) -> str:
    if rate.value is None:
        return '<td class="none">–</td>'
    ends = f"[{number(rate.low, 2)}, {number(rate.high, 2)}]"
    return (
        f'<td style="--shade:{shade(rate.value):.2f}" data-value="{rate.value!r}"><span class="value">'
        f'{number(rate.value, 2)}</span> <span class="interval">{ends}</span></td>'
    )
