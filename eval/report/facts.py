"""What was flown and with what: enough to repeat the run."""

from __future__ import annotations

import json
from collections.abc import Mapping

from rss_gym.eval.evaluate import Result
from rss_gym.eval.report.tables import scrolled
from rss_gym.pages.page import text


def lead(result: Result) -> str:
    """The lines under the page's title."""
    suite = result.suite
    kind = "official run" if result.official else "not an official run"
    policies = f"{len(result.policies)} policies" if len(result.policies) > 1 else "1 policy"
    encounters = f"the same {result.episodes:,} encounters" if result.episodes > 1 else "1 encounter"
    return (
        f'<p class="lead">{policies} on {encounters} of suite '
        f"<strong>{text(suite.name)}</strong> ({text(suite.summary)}).</p>\n"
        f'<p class="tags"><span>{kind}</span><span>split {text(suite.split)}</span><span>seed {result.seed}</span>'
        f"<span>suite hash {text(suite.hash[:12])}</span></p>"
    )


def run(result: Result, packages: Mapping[str, str]) -> str:
    """Suite, seed and versions; how to build each policy; all parameters of the world."""
    suite = result.suite
    official = (
        "yes"
        if result.official
        else f"no; such a run has {suite.episodes:,} encounters of seed {suite.seed} and the suite unchanged"
    )
    rows = {
        "suite": suite.name,
        "suite hash": suite.hash,
        "split": suite.split,
        "seed": result.seed,
        "encounters": f"{result.episodes:,}",
        "official": official,
        "families": ", ".join(suite.families),
        "safety zone": f"{suite.params.zone.radius_m:g} m",
        "estimator": suite.params.ranging.estimator,
        "versions": ", ".join(f"{name} {version}" for name, version in packages.items()),
    }
    facts = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>\n" for name, value in rows.items())
    parameters = json.dumps(suite.params.to_dict(), indent=1)
    return (
        f'<dl class="facts">\n{facts}</dl>\n<h3>Policies</h3>\n{_policies(result)}'
        f"<details><summary>Parameters of the world</summary><pre>{text(parameters)}</pre></details>"
    )


def _policies(result: Result) -> str:
    """How each policy was made, where its name does not say so, and what it was flown with."""
    entries = [scored.entry for scored in result.policies]
    columns: dict[str, list[str | None]] = {
        "made by": [entry.spec for entry in entries],
        "information": [entry.params.interface.information for entry in entries],
        "actions": [entry.action for entry in entries],
        "hash": [entry.hash[:16] for entry in entries],
    }
    if columns["made by"] == [entry.name for entry in entries]:
        del columns["made by"]
    if None in columns["actions"]:  # of a record that does not tell them
        del columns["actions"]
    headings = '<th scope="col">policy</th>' + "".join(f'<th scope="col" class="words">{key}</th>' for key in columns)
    rows = ""
    for entry, *values in zip(entries, *columns.values(), strict=True):
        cells = "".join(f'<td class="words">{text(value)}</td>' for value in values)
        rows += f'<tr><th scope="row">{text(entry.name)}</th>{cells}</tr>\n'
    return scrolled(f"<table><thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody></table>")
