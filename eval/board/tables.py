"""The tables of a board's pages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from rss_gym.eval.board.standing import Row as Standing
from rss_gym.eval.columns import AIR, MORE
from rss_gym.eval.intervals import Interval
from rss_gym.eval.ranking import FRONT
from rss_gym.pages.markup import renderer
from rss_gym.pages.table import Cell, Column, Row, Table

render = renderer(__file__)
# Metric -> how it is shown; a season has some thousand encounters.
SHOWN = {"collision_rate": ".4f", "snmac_rate": ".4f", "path_deviation_mean_m": ".1f"}
COST = replace(AIR["cost_m"], title="cost, sealed", form=",.1f")
PUBLIC = replace(COST, title="cost, public")
MORE_M = replace(MORE, form="+,.1f")
GAP = replace(MORE_M, title="sealed less public")
COLLISIONS = replace(AIR["collision_rate"], title="collisions, sealed", form=".4f", interval=False)
SUITES = (
    "suite",
    Column("entries", form=",", words=False),
    Column("first", words=True),
    replace(COST, title="its cost"),
    "encounters, public and sealed",
)
STANDING = (
    "place",
    Column("entry", words=True, head=True),
    COST,
    MORE_M,
    PUBLIC,
    GAP,
    *(replace(AIR[metric], form=form) for metric, form in SHOWN.items()),
)
OF_ENTRY = ("season and suite", "place", COST, PUBLIC, COLLISIONS)


def season(suites: Sequence[Mapping[str, Any]]) -> Table:
    """The suites of a season, each with who leads its first level of information."""
    rows = []
    for suite in suites:
        leaders = [rows[0] for rows in list(suite["levels"].values())[:1] if rows and rows[0].place]
        first = [one.line["entry"]["name"] for one in leaders] or [None]
        cost = [one.line["sealed"]["metrics"]["cost_m"]["value"] for one in leaders] or [None]
        flown = suite["flown"]
        counts = f"{flown.public} + {flown.sealed}"
        rows.append([_link(suite["page"], flown.name), str(suite["count"]), *first, *cost, counts])
    return Table(SUITES, rows, "board")


def level(standings: Sequence[Standing]) -> Table:
    """The entries on a suite, on one level of information."""
    return Table(STANDING, map(_standing, standings), "board")


def by(standings: Sequence[Standing], kind: str) -> Table | None:
    """The cost of the sealed encounters by family or radio (`kind`), where there are several."""
    flown = [one for one in standings if not one.line["failed"]]
    names = list(flown[0].line["sealed"][kind]) if flown else []
    if len(names) < 2:
        return None
    rows = ([one.line["entry"]["name"], *_costs(one.line["sealed"][kind], names)] for one in flown)
    return Table(["entry", *(replace(COST, title=name, unit="") for name in names)], rows, "board")


def entry(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Where an entry stands, in each season and suite."""
    return Table(OF_ENTRY, map(_of_entry, rows), "board")


def _standing(one: Standing) -> Row:
    line = one.line
    place = Cell(None) if one.place is None else Cell(str(one.place), one.place, mark=FRONT * one.front)
    small = "; ".join(filter(None, (line["entry"]["author"], one.why_not)))
    name = Cell(_link(f"entries/{line['entry_hash'][:16]}.html", line["entry"]["name"]), small=small)
    class_ = "out" if one.why_not else ""
    if line["failed"]:
        return Row([place, name, *[""] * (len(STANDING) - 2)], class_)
    sealed, gap = line["sealed"]["metrics"], _estimate(line["gap_m"])
    gap_cell = GAP.cell(gap)
    if one.alarm:
        gap_cell = Cell(f"{gap_cell.text} !", gap.value, gap.low, gap.high, gap_cell.ends, class_="alarm")
    more = Interval(*one.more, 0) if one.more else ""
    costs = [_estimate(sealed["cost_m"]), more, _estimate(line["public"]["metrics"]["cost_m"]), gap_cell]
    return Row([place, name, *costs, *(_estimate(sealed[metric]) for metric in SHOWN)], class_)


def _of_entry(one: Mapping[str, Any]) -> Row:
    standing = one["row"]
    name = Cell(_link(f"../{one['page']}", f"{one['season']}, {one['suite']}"), small=standing.why_not)
    place = None if standing.place is None else str(standing.place)
    scores: list[Any] = ["", "", ""]
    if not standing.line["failed"]:
        sealed, public = (standing.line[part]["metrics"] for part in ("sealed", "public"))
        scores = [sealed["cost_m"]["value"], public["cost_m"]["value"], sealed["collision_rate"]["value"]]
    return Row([name, place, *scores], "out" if standing.why_not else "")


def _costs(found: Mapping[str, Any], names: Sequence[str]) -> list[Any]:
    return [found[name]["cost_m"] if name in found else "" for name in names]


def _estimate(metric: Mapping[str, Any]) -> Interval:
    return Interval(metric["value"], metric["low"], metric["high"], 0)


def _link(page: str, name: str) -> Markup:
    return render("link.html", page=page, name=name)
