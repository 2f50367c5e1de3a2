"""What there is to choose from, for `rss-gym list`."""

from pathlib import Path

from rss_gym.baselines import describe
from rss_gym.encounters import FAMILIES, MIXED
from rss_gym.eval.suites import SUITES
from rss_gym.ids import IDS
from rss_gym.params import presets
from rss_gym.train.recipe import load, recipes


def listing() -> dict[str, dict[str, str]]:
    """Title -> name -> one line."""
    return {
        "ids": {
            name: ", ".join(f"{k}={v!r}" for k, v in keywords.items()) or "default" for name, keywords in IDS.items()
        },
        "policies": {
            name: item["summary"] + "".join(f" [{key}={value:g}]" for key, value in item["options"].items())
            for name, item in describe().items()
        },
        "channels": {name: _first_line(path) for name, path in presets().items()},
        "families": {MIXED: "all of these, by their weights"}
        | {name: f"{family.summary} [weight {family.weight:g}]" for name, family in FAMILIES.items()},
        "recipes": {name: f"{load(name).summary} [{load(name).steps} decisions]" for name in recipes()},
        "suites": {name: f"{suite.summary} [{suite.episodes} encounters]" for name, suite in SUITES.items()},
    }


def _first_line(path: Path) -> str:
    return path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
