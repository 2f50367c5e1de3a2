"""What there is to choose from, for `rss-gym list`."""

from collections.abc import Iterator

from rss_gym.baselines import describe, road
from rss_gym.encounters import FAMILIES, MIXED
from rss_gym.eval.road import SUITES as ROAD_SUITES
from rss_gym.eval.suites import SUITES
from rss_gym.highway.env import SCENES
from rss_gym.ids import IDS, ROADS
from rss_gym.params import CHANNELS
from rss_gym.train.recipe import load, recipes
from rss_gym.train.road import recipe as road_recipe


def listing() -> dict[str, dict[str, str]]:
    """Title -> name -> one line."""
    return {
        "ids": {
            name: ", ".join(f"{k}={v!r}" for k, v in keywords.items()) or "default" for name, keywords in IDS.items()
        }
        | {name: f"highway-env: {SCENES[str(keywords['scene'])].summary}" for name, keywords in ROADS.items()},
        "policies": {
            name: item["summary"] + "".join(f" [{key}={value:g}]" for key, value in item["options"].items())
            for name, item in describe().items()
        },
        "drivers": road.describe(),
        "channels": {name: preset.summary for name, preset in CHANNELS.items()},
        "families": {MIXED: "all of these, by their weights"}
        | {name: f"{family.summary} [weight {family.weight:g}]" for name, family in FAMILIES.items()},
        "recipes": {name: f"{load(name).summary} [{load(name).steps} decisions]" for name in recipes()}
        | {name: f"{found.head.summary} [{found.head.steps} decisions]" for name, found in _road_recipes()},
        "suites": {
            name: f"{suite.summary} [{suite.episodes} encounters]" for name, suite in {**SUITES, **ROAD_SUITES}.items()
        },
    }


def _road_recipes() -> Iterator[tuple[str, road_recipe.RoadRecipe]]:
    return ((name, road_recipe.load(name)) for name in road_recipe.recipes())
