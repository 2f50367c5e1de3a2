"""The page of the reproduction, and its tables as Markdown."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from rss_gym.eval.paper.number import Number, counts
from rss_gym.eval.paper.panel import Panel
from rss_gym.eval.paper.study import METHODS, Study
from rss_gym.eval.records import versions
from rss_gym.eval.report.numbers import MINUS
from rss_gym.eval.report.numbers import number as shown
from rss_gym.eval.report.tables import scrolled
from rss_gym.pages.page import Section, render, text

TITLE = "The paper's figures and numbers"
SIGNS = {"equals": "", "at least": "≥ ", "at most": "≤ "}
HEADS = ("what", "paper", "measured", "agrees", "role", "note")
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
        Section("How to read it", _reading(study)),
        *(Section(panel.title, _panel(panel)) for panel in panels),
        Section("All numbers", _table(numbers)),
        Section("Run", _run(study)),
    ]
    lead = (
        '<p class="lead">C. Luo et al., “UAV Position Estimation and Collision Avoidance Using the Extended Kalman '
        f"Filter”, 2013, computed by this package. {text(summary(numbers))}</p>\n"
        f'<p class="tags"><span>seed {study.seed}</span><span>channel preset paper</span></p>'
    )
    return render(TITLE, lead, sections)


def summary(numbers: Sequence[Number]) -> str:
    """How many agree, in one sentence for each role."""
    tally = counts(numbers)
    parts = [f"{good} of {total} {PHRASES[role]}" for role, (good, total) in tally.items() if total]
    return ", ".join(parts) + "; what was used to choose the channel is not counted."


def markdown(numbers: Sequence[Number]) -> str:
    """The table of all numbers as Markdown."""
    lines = ["| " + " | ".join(HEADS) + " |", "|---" * len(HEADS) + "|"]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in _cells(number)) + " |" for number in numbers]
    return "\n".join(lines)


def _cells(number: Number) -> tuple[str, ...]:
    """Plain texts in the order of `HEADS`."""
    verdict = {True: "yes", False: "no", None: "–"}[number.agrees]
    unit = f" {number.unit}" if number.unit else ""
    paper = f"{SIGNS[number.relation]}{_plain(number.paper)}"
    if number.tolerance > 0.0:
        paper += f" ± {_plain(number.tolerance, 2)}"
    measured = f"{_measured(number)}{_interval(number)}"
    return number.what, paper + unit, measured + unit, verdict, number.role, number.note


def _plain(value: float, digits: int = 4) -> str:
    """To so many digits, without trailing zeros."""
    if value == 0.0 or 1e-3 <= abs(value) < 10.0**digits:
        return f"{value:.{digits}g}".replace("-", MINUS)
    return shown(value, min(digits, 3))


def _measured(number: Number) -> str:
    return _plain(number.measured) if number.seen.low == number.seen.high else shown(number.measured)


def _interval(number: Number) -> str:
    return "" if number.seen.low == number.seen.high else f" [{shown(number.seen.low)}, {shown(number.seen.high)}]"


def _panel(panel: Panel) -> str:
    said = (
        f'<p class="text"><strong>The paper.</strong> {_formulas(panel.paper)}</p>\n'
        f'<p class="text"><strong>Here.</strong> {_formulas(panel.here)}</p>\n'
    )
    return said + panel.markup + (_table(panel.numbers) if panel.numbers else "")


def _formulas(plain: str) -> str:
    """Plain text as markup, with U_i, 1e-5 and 0.2^7 as formulas and a percent sign that stays with its number."""
    markup = re.sub(r"\b([A-Za-z])_([A-Za-z])\b", r"\1<sub>\2</sub>", text(plain)).replace(" %", "&nbsp;%")
    markup = re.sub(r"(\d)\^(\d+)", r"\1<sup>\2</sup>", markup)
    return re.sub(r"\b(?:1|(\d\.?\d*))e([+-])0?(\d+)\b", _power, markup)


def _power(found: re.Match[str]) -> str:
    mantissa, sign, digits = found.groups()
    return f"{mantissa + '×' if mantissa else ''}10<sup>{MINUS if sign == '-' else ''}{digits}</sup>"


def _table(numbers: Sequence[Number]) -> str:
    classes = ("", "", "", ' class="words"', ' class="words"', ' class="words"')
    heads = "".join(f'<th scope="col"{kind}>{head}</th>' for head, kind in zip(HEADS, classes, strict=True))
    rows = ""
    for number in numbers:
        what, paper, _, verdict, role, note = map(_formulas, _cells(number))
        unit = f" {text(number.unit)}" if number.unit else ""
        measured = (
            f'<td data-value="{number.measured!r}"><span class="value">{_measured(number)}{unit}</span>'
            f'<span class="interval">{_interval(number)}</span></td>'
        )
        words = "".join(
            f'<td class="words">{cell}</td>'
            for cell in (f"<strong>{verdict}</strong>", f'<span class="value">{role}</span>', note)
        )
        rows += (
            f'<tr><th scope="row"><span class="who"><span>{what}</span></span></th>'
            f'<td><span class="value">{paper}</span></td>{measured}{words}</tr>\n'
        )
    return scrolled(f"<table><thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table>")


def _reading(study: Study) -> str:
    size = study.size
    return "".join(
        f'<p class="text">{line}</p>\n'
        for line in (
            "The paper's flights and radio logs are not published. Everything here is simulated with the kernels of "
            "the world that the environment flies: RSS with white and coloured noise and a path loss factor that "
            "wanders.",
            f"In brackets: the middle 95 % of {size.repetitions} repetitions of the twelve flights, or a 95 % "
            "confidence interval where trials are counted. <strong>agrees</strong> is computed: the paper's figure "
            "lies in the bracket widened by the tolerance after ±; of a claim, the whole bracket is on the stated "
            "side of the threshold. A figure that the paper gives as “about 4 m” has a tolerance of a tenth.",
            "A number <strong>beside</strong> was measured under conditions that are not the paper's, to show "
            "what they "
            "change. A <strong>calibrated</strong> number was used to choose the channel preset and says "
            "nothing. A number "
            "<strong>by construction</strong> follows from how it is counted.",
            "Each filter has a process noise of its own, tuned alike on eight other flights under other noise (table "
            "under Run).",
        )
    )


def _run(study: Study) -> str:
    """The tuning, the sizes, and what it ran with."""
    floor = study.noise_floor_m2_ps
    rows = ""
    for name, method in METHODS.items():
        if not method.tuned:
            continue
        at_floor = "–"
        if not method.velocity:
            errors = study.flown.errors_m(method, study.channel, floor)
            at_floor = f"{np.median(np.quantile(errors, 0.8, axis=1)):.2f}"
        rows += (
            f'<tr><th scope="row">{text(method.label)}</th><td>{shown(study.noise_m2_ps(name))}</td>'
            f"<td>{np.median(study.p80_m(name)):.2f}</td><td>{at_floor}</td></tr>\n"
        )
    heads = ("filter", "Var(w) tuned, m²/s", "80 % error with it, m", f"80 % error with {floor:.3g} m²/s, m")
    table = (
        "<table><thead><tr>" + "".join(f'<th scope="col">{head}</th>' for head in heads) + "</tr></thead>\n"
        f"<tbody>\n{rows}</tbody></table>"
    )
    facts = {
        "seed": study.seed,
        **{SIZES[name]: f"{value:,}" for name, value in study.size.to_dict().items()},
        "versions": ", ".join(f"{name} {number}" for name, number in versions().items()),
    }
    listed = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>\n" for name, value in facts.items())
    return (
        '<p class="text">Process noise, as a variance per second: of the grid 10<sup>−3</sup> to 10<sup>3</sup> in '
        "quarter decades, what errs least at 80 % on the flights for tuning. The last column has the random walk "
        "that spreads as the flights do, 2 T<sub>v</sub> σ<sub>v</sub><sup>2</sup>; straight legs let the tuned "
        f"filters stay below it.</p>\n{scrolled(table)}\n<dl>\n{listed}</dl>"
    )
