"""What was flown and with what: enough to repeat the run."""

from __future__ import annotations

import json

from rss_gym.eval import records
from rss_gym.eval.evaluate import Result
from rss_gym.eval.report.page import text
from rss_gym.eval.report.tables import scrolled


def lead(result: Result) -> str:
    """The lines under the page's title."""
    suite = result.suite
    kind = "official run" if result.official else "not an official run"
    policies = f"{len(result.policies)} policies" if len(result.policies) > 1 else "1 policy"
    return (
        f'<p class="lead">{text(policies)} on the same {result.episodes:,} encounters of suite '
        f"<strong>{text(suite.name)}</strong> ({text(suite.summary)}).</p>\n"
        f'<p class="tags"><span>{kind}</span><span>split {text(suite.split)}</span><span>seed {result.seed}</span>'
        f"<span>suite hash {text(suite.hash[:12])}</span></p>"
    )


def run(result: Result) -> str:
    """Suite, seed and versions; how to build each policy; all parameters of the world."""
    suite = result.suite
    official = "yes" if result.official else f"no; such a run has {suite.episodes:,} encounters of seed {suite.seed} and the suite unchanged"
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
        "versions": ", ".join(f"{name} {version}" for name, version in records.versions().items()),
    }
    facts = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>\n" for name, value in rows.items())
    policies = "".join(
        f'<tr><th scope="row">{text(entry.name)}</th><td class="words"><code>{text(entry.spec)}</code></td>'
        f'<td class="words">{text(entry.world.interface.track)}</td><td class="words"><code>{text(entry.hash[:16])}</code></td></tr>\n'
        for entry in (scored.entry for scored in result.policies)
    )
    parameters = json.dumps(suite.params.to_dict(), indent=1)
    return (
        f'<dl class="facts">\n{facts}</dl>\n<h3>Policies</h3>\n'
        + scrolled(
            '<table class="policies"><thead><tr><th scope="col">name</th><th scope="col" class="words">made by</th>'
            '<th scope="col" class="words">track</th><th scope="col" class="words">hash</th></tr></thead>\n'
            f"<tbody>\n{policies}</tbody></table>"
        )
        + f"<details><summary>Parameters of the world</summary><pre>{text(parameters)}</pre></details>"
    )
