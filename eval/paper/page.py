"""The page of the reproduction, and its tables as Markdown."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from rss_gym.eval.paper.number import Number, counts
from rss_gym.eval.paper.panel import Panel
from rss_gym.eval.paper.study import METHODS, Study
from rss_gym.eval.records import versions
from rss_gym.pages import page
from rss_gym.pages.markup import renderer
from rss_gym.pages.numbers import MINUS
from rss_gym.pages.numbers import number as shown
from rss_gym.pages.page import Section
from rss_gym.pages.table import Cell, Column, Table

TITLE = "The paper's figures and numbers"
SIGNS = {"equals": "", "at least": "≥ ", "at most": "≤ "}
HEADS = (
    "what",
    "paper",
    "measured",
    Column("agrees", words=True),
    Column("role", words=True),
    Column("note", words=True),
)
render = renderer(__file__)
PHRASES = {
    "reproduced": "numbers computed anew agree",
    "claim": "claims in words hold by their criteria",
    "by construction": "numbers agree by construction",
}
SIZES = {
    "repetitions": "repetitions of the twelve flights",
    "tuning": "of the eight for tuning",
    "circular": "with γ from the filter's own distances",
    "allan": "records of an hour",
    "trials": "trials counted",
    "approaches": "approaches flown",
    "pairs": "pairs of trajectories",
    "scan": "repetitions on each radio of the scan",
}


def markup(study: Study, panels: Sequence[Panel]) -> str:
    """The page as text; the same study gives the same text."""
    numbers = [number for panel in panels for number in panel.numbers]
    sections = [
        Section("How to read it", render("reading.html", size=study.size)),
        *(Section(panel.title, _panel(panel)) for panel in panels),
        Section("All numbers", _table(numbers, formulas).html),
        Section("Run", _run(study)),
    ]
    lead = render("lead.html", summary=summary(numbers), seed=study.seed)
    return page.render(TITLE, lead, sections)


def summary(numbers: Sequence[Number]) -> str:
    """How many agree, in one sentence for each role."""
    tally = counts(numbers)
    parts = [f"{good} of {total} {PHRASES[role]}" for role, (good, total) in tally.items() if total]
    return ", ".join(parts) + "; what was used to choose the channel is not counted."


def markdown(numbers: Sequence[Number]) -> str:
    """The table of all numbers as Markdown."""
    return _table(numbers).markdown


def _table(numbers: Sequence[Number], words: Callable[[str], str] = str) -> Table:
    """All numbers; `words` shows texts."""
    return Table(HEADS, (_row(number, words) for number in numbers))


def _row(number: Number, words: Callable[[str], str]) -> list[Any]:
    """The cells in the order of `HEADS`; the unit stands behind each number, as rows have different ones."""
    verdict = {True: "yes", False: "no", None: "–"}[number.agrees]
    unit = f" {number.unit}" if number.unit else ""
    paper = f"{SIGNS[number.relation]}{_plain(number.paper)}"
    if number.tolerance > 0.0:
        paper += f" ± {_plain(number.tolerance, 2)}"
    low, high = number.seen.low, number.seen.high
    measured = Cell(
        _plain(number.measured) if low == high else shown(number.measured),
        number.measured,
        ends=None if low == high else (shown(low), shown(high)),
        unit=number.unit,
    )
    agrees = Cell(verdict, strong=words is not str)
    return [Cell(words(number.what), dot=""), words(paper + unit), measured, agrees, number.role, words(number.note)]


def _plain(value: float, digits: int = 4) -> str:
    """To so many digits, without trailing zeros."""
    if value == 0.0 or 1e-3 <= abs(value) < 10.0**digits:
        return f"{value:.{digits}g}".replace("-", MINUS)
    return shown(value, min(digits, 3))


def _panel(panel: Panel) -> Markup:
    table = _table(panel.numbers, formulas) if panel.numbers else None
    return render("panel.html", panel=panel, paper=formulas(panel.paper), here=formulas(panel.here), table=table)


def formulas(plain: str) -> Markup:
    """Plain text as markup, with U_i, 1e-5 and 0.2^7 as formulas and a percent sign that stays with its number."""
    markup = re.sub(r"\b([A-Za-z])_([A-Za-z])\b", r"\1<sub>\2</sub>", str(escape(plain))).replace(" %", "&nbsp;%")
    markup = re.sub(r"(\d)\^(\d+)", r"\1<sup>\2</sup>", markup)
    return Markup(re.sub(r"\b(?:1|(\d\.?\d*))e([+-])0?(\d+)\b", _power, markup))


def _power(found: re.Match[str]) -> str:
    mantissa, sign, digits = found.groups()
    return f"{mantissa + '×' if mantissa else ''}10<sup>{MINUS if sign == '-' else ''}{digits}</sup>"


def _run(study: Study) -> Markup:
    """The tuning, the sizes, and what it ran with."""
    floor = study.noise_floor_m2_ps
    rows: list[list[Any]] = []
    for name, method in METHODS.items():
        if not method.tuned:
            continue
        at_floor = None
        if not method.velocity:
            errors = study.flown.errors_m(method, study.channel, floor)
            at_floor = float(np.median(np.quantile(errors, 0.8, axis=1)))
        rows.append([method.label, study.noise_m2_ps(name), float(np.median(study.p80_m(name))), at_floor])
    columns = (
        "filter",
        Column("Var(w) tuned", "m²/s", shown),
        Column("80 % error with it", "m", ".2f"),
        Column(f"80 % error with {floor:.3g} m²/s", "m", ".2f"),
    )
    facts = {
        "seed": study.seed,
        **{SIZES[name]: f"{value:,}" for name, value in study.size.to_dict().items()},
        "versions": ", ".join(f"{name} {number}" for name, number in versions().items()),
    }
    return render("run.html", table=Table(columns, rows), facts=facts)
