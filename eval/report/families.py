"""Collisions in each family of encounters, as a table whose shades follow the logarithm of the rate."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from markupsafe import Markup

from rss_gym.eval.evaluate import Result
from rss_gym.eval.intervals import Interval, clopper_pearson
from rss_gym.eval.report.tables import policies
from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import MISSING, short
from rss_gym.pages.table import Cell, Column, Table

render = renderer(__file__)
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


def breakdown(result: Result) -> Markup:
    """The table."""
    found = rates(result)
    columns = [
        Column(name, form=short, note=f"n = {interval.n:,}")
        for name, interval in zip(result.suite.families, found[0], strict=True)
    ]
    rows = (
        [name, *(_cell(column, rate) for column, rate in zip(columns, rates_of_one, strict=True))]
        for name, rates_of_one in zip(policies(result), found, strict=True)
    )
    return render("families.html", table=Table(["policy", *columns], rows, "heat sortable"))


def _cell(column: Column, rate: Interval) -> Cell:
    if rate.value is None:
        return Cell(MISSING, class_="none")
    return dataclasses.replace(column.cell(rate), style=f"--shade:{shade(rate.value):.2f}")
