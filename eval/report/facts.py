"""What was flown and with what: enough to repeat the run."""

from __future__ import annotations

import json
from collections.abc import Mapping

from markupsafe import Markup

from rss_gym.eval.evaluate import Result
from rss_gym.pages.markup import renderer
from rss_gym.pages.table import Column, Table

render = renderer(__file__)


def lead(result: Result) -> Markup:
    """The lines under the page's title."""
    return render("lead.html", result=result)


def run(result: Result, packages: Mapping[str, str]) -> Markup:
    """Suite, seed and versions; how to build each policy; all parameters of the world."""
    suite = result.suite
    official = (
        "yes"
        if result.official
        else f"no; such a run has {suite.episodes:,} encounters of seed {suite.seed} and the suite unchanged"
    )
    facts = {
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
    parameters = json.dumps(suite.params.to_dict(), indent=1)
    return render("run.html", facts=facts, policies=_policies(result), parameters=parameters)


def _policies(result: Result) -> Table:
    """How each policy was made, where its name does not say so, and what it was flown with."""
    entries = [scored.entry for scored in result.policies]
    columns: dict[str, list[str | None]] = {
        "policy": [entry.name for entry in entries],
        "made by": [entry.spec for entry in entries],
        "information": [entry.params.interface.information for entry in entries],
        "actions": [entry.action for entry in entries],
        "hash": [entry.hash[:16] for entry in entries],
    }
    if columns["made by"] == columns["policy"]:
        del columns["made by"]
    if None in columns["actions"]:  # of a record that does not tell them
        del columns["actions"]
    rows = zip(*columns.values(), strict=True)
    return Table([Column(title, words=title != "policy") for title in columns], rows)
