"""Ships the agent of a run: python -m rss_gym.train.ship RUN --name NAME [--limits FILE] [--encounters N].

Makes baselines/agents/NAME/ from the folder of a finished `rss-gym train`: the policy of the cheapest seed, a card, and
the validations of all seeds as a table and a chart. Made anew, it takes the place of the older one. With `--encounters`
the policies of all seeds are flown over so many encounters of split `validation` before the cheapest is taken.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.policy_files import DOCUMENT, WEIGHTS
from rss_gym.baselines.shipped import CARD, FOLDER
from rss_gym.eval.metrics import Estimate
from rss_gym.eval.text import cell
from rss_gym.files import replaced_folder, write_text
from rss_gym.highway.params import RoadParams
from rss_gym.highway.scene import SCENES
from rss_gym.pages import figure
from rss_gym.params import CHANNELS, Params, ParamsError, load_channel
from rss_gym.train import recipe as recipes
from rss_gym.train import run as runs
from rss_gym.train.recipe import Recipe
from rss_gym.train.run_record import AGENT, BEST, copy_policy
from rss_gym.train.validation import Validator

CURVES, CHART = "curves.csv", "curves.svg"
NAME = re.compile("[a-z][a-z0-9-]{1,40}")
COLUMNS: tuple[str, ...] = ("steps", "episodes", "cost_m", "cost_low_m", "cost_high_m", "collisions", "collision_rate")
COLUMNS += ("collision_rate_low", "collision_rate_high", "snmac_rate", "path_deviation_mean_m", "best")


@dataclass(frozen=True)
class Seed:
    """One training: its seed, the policy that was kept, and its validations in order; `again` is one more."""

    number: int
    folder: Path
    agent: Agent
    rows: list[dict[str, str]]
    again: dict[str, Any] | None = None

    @property
    def kept(self) -> dict[str, Any]:
        """The validation of the kept policy."""
        return dict(self.agent.document["training"]["validation"])

    def points(self, name: str) -> list[float]:
        """A column of the validations."""
        return [float(row[name]) for row in self.rows]


def seeds_of(run: Path, recipe: Recipe, numbers: list[int]) -> list[Seed]:
    """All of a finished run."""
    seeds = []
    for index, number in enumerate(numbers):
        folder = run / f"seed-{index}"
        with open(folder / "validation.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        if int(rows[-1]["steps"]) < recipe.steps:
            raise ParamsError(f"{folder} has {rows[-1]['steps']} of {recipe.steps} steps; train it to its end first")
        seeds.append(Seed(number, folder / BEST, load(folder / BEST, recipe.params), rows))
    return seeds


def flown_again(seeds: list[Seed], recipe: Recipe, encounters: int) -> list[Seed]:
    """All over the same encounters of split `validation`, the cheapest first; one with a fault comes last."""
    validator = Validator(recipe.params, encounters)
    scores = [(seed, validator.score(seed.agent, f"{seed.number}").to_dict()) for seed in seeds]
    scores.sort(key=lambda item: (item[1]["faults"], item[1]["cost_m"]))
    return [replace(seed, again=score) for seed, score in scores]


def card(name: str, recipe: Recipe, document: dict[str, Any], seeds: list[Seed], shipped: Seed, limits: str) -> str:
    """What the agent is, how it was made, what it reached and what it is not for."""
    head, network, params = recipe.to_dict()["recipe"], shipped.agent.document["network"], recipe.params
    facts = {
        "recipe": f"`{recipe.name}`, {recipe.steps:,} decisions a seed; every number of it is in `{DOCUMENT}`",
        **changed(recipe),
        "world": f"`{recipe.env}`, {described(params)}",
        "other than the id's": listed({key: value for key, value in recipe.world.items() if key != "channel"}),
        **later(recipe),
        "network": ", ".join(f"{key} {json.dumps(value)}" for key, value in network.items()),
        "seeds": f"{', '.join(str(seed.number) for seed in seeds)}; shipped: {shipped.number}",
        "versions": ", ".join(f"{key} {value}" for key, value in document["versions"].items()),
        "revision": f"{document['revision']}",
        f"SHA-256 of `{DOCUMENT}` and `{WEIGHTS}`": f"{shipped.agent.digest}",
    }
    order = sorted(seeds, key=lambda seed: seed is not shipped)
    titles = ["seed", "decisions", "encounters", "cost, m", "collisions", "mean deviation, m"]
    return f"""# {name}

Learned with {head["algorithm"]} in `{recipe.env}`: {recipe.summary}. `rss-gym eval --policy {name}` flies it.

{table(["", ""], [[key, value] for key, value in facts.items()])}

## Validation

{chosen(shipped)}

{table(titles, [row(seed) for seed in order])}

![Cost, collision rate and mean deviation of all seeds over the training]({CHART})

A hollow point had no collision and stands at the upper end of its interval. All validations are in `{CURVES}`.

## Limits

- Trained and validated in the world above only: {described(params)}.
- It refuses worlds with another observation: planar or not, intruders and information must be as in training.
- Flown in simulation only.
{limits.strip()}
"""


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown, one line a row."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def chosen(shipped: Seed) -> str:
    """On what the shipped seed was chosen."""
    which, number = "at the validation that was kept, its cheapest", ""
    if shipped.again is not None:
        which, number = "as kept on its own validations", f"{shipped.again['episodes']:,} "
    return (
        f"Each seed's policy, {which}, over the same {number}encounters of split `validation`;\nthe shipped one first: "
        "the cheapest. It was chosen on them, so they flatter it a little."
    )


def row(seed: Seed) -> list[str]:
    """A seed in the card's table."""
    kept = seed.kept | (seed.again or {})
    cost = Estimate(kept["cost_m"], kept["cost_low_m"], kept["cost_high_m"], kept["episodes"], "m")
    rates = (kept[f"collision_rate{end}"] for end in ("", "_low", "_high"))
    rate = Estimate(next(rates), next(rates), next(rates), kept["episodes"], "1")
    deviation = f"{kept['path_deviation_mean_m']:.2f}"
    numbers = [f"{seed.number}", f"{kept['steps']:,}", f"{kept['episodes']:,}"]
    return [*numbers, cell(cost, 1.0, ".2f"), cell(rate, 1.0, ".2e"), deviation]


def described(params: Params) -> str:
    """What of a world a policy depends on, in words."""
    encounter = params.encounter
    names = {load_channel(name): name for name in CHANNELS}
    channels = list(dict.fromkeys(names[channel] for channel in params.channels if channel in names))
    others = sum(channel not in names for channel in params.channels)
    if others:
        channels.append(f"{others} of its own (in {DOCUMENT})")
    several = f"{encounter.intruders_min} to " if encounter.intruders_min else ""
    what = {"": "planar" if encounter.planar else "in space", "intruders: ": f"{several}{encounter.intruders}"}
    rest = {"families: ": f"{encounter.families}", "tracker ": f"`{params.tracking.tracker}`"}
    if isinstance(params, RoadParams):
        what, rest = {"": SCENES[params.road.scene].summary, "vehicles observed: ": f"{encounter.intruders}"}, {}
    parts = {
        **what,
        "information ": f"`{params.interface.information}`",
        "channels: ": ", ".join(channels),
        "estimator ": f"`{params.ranging.estimator}`",
        **rest,
    }
    return "; ".join(key + value for key, value in parts.items())


def changed(recipe: Recipe) -> dict[str, str]:
    """What differs from the shipped recipe of that name."""
    if recipe.name not in recipes.recipes():
        return {}
    plain = recipes.load(recipe.name).to_dict()
    ours = recipe.to_dict()
    differs = {
        f"{section}.{key}": value
        for section, found in ours.items()
        if isinstance(found, dict)
        for key, value in found.items()
        if plain[section].get(key) != value
    }
    if ours["curriculum"] != plain["curriculum"]:
        differs["curriculum"] = ours["curriculum"]
    return {"other than in `train/recipes/`": listed(differs)} if differs else {}


def later(recipe: Recipe) -> dict[str, str]:
    """What the curriculum changes, and when."""
    stages = (f"from {stage.start:.0%} of the steps on {', '.join(sorted(stage.world))}" for stage in recipe.curriculum)
    return {"changes on the way": "; ".join(stages)} if recipe.curriculum else {}


def listed(values: dict[str, Any]) -> str:
    """`key = value` with commas between."""
    return ", ".join(f"{key} = {json.dumps(value)}" for key, value in values.items()) or "nothing"


def curves(seeds: list[Seed]) -> str:
    """The validations of all seeds as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["seed", *COLUMNS])
    writer.writerows([seed.number, *(line[name] for name in COLUMNS)] for seed in seeds for line in seed.rows)
    return text.getvalue()


def chart(seeds: list[Seed], shipped: Seed) -> str:
    """Cost, collision rate and deviation over the decisions, a line a seed, the kept policies marked; an SVG file."""
    label = "Validation of each seed over its training: cost, collision rate and mean deviation"
    with figure.figure(label, columns=3, width_in=10.0, height_in=3.4) as drawing:
        for index, seed in enumerate(seeds):
            steps, colour = [step / 1e6 for step in seed.points("steps")], figure.COLOURS[index % len(figure.COLOURS)]
            # Without a collision the point is the upper end of its interval.
            ends = zip(seed.points("collision_rate"), seed.points("collision_rate_high"), strict=True)
            rates = [rate or high for rate, high in ends]
            kept = seed.points("steps").index(seed.kept["steps"])
            name = f"seed {seed.number}{', shipped' if seed is shipped else ''}"
            heights = (seed.points("cost_m"), rates, seed.points("path_deviation_mean_m"))
            for axes, values in zip(drawing.axes, heights, strict=True):
                axes.plot(steps, values, color=colour, linewidth=2.0 if seed is shipped else 1.0, label=name)
                axes.plot(steps[kept], values[kept], "o", color=colour, markersize=5)
            clear = [at for at, rate in enumerate(seed.points("collision_rate")) if not rate]
            hollow = {"color": colour, "markerfacecolor": "white"}
            drawing.axes[1].plot([steps[at] for at in clear], [rates[at] for at in clear], "o", **hollow)
        cost, rate, deviation = drawing.axes
        cost.set(yscale="log", ylabel="cost, m", xlabel="decisions, millions")
        rate.set(yscale="log", ylabel="collisions per encounter", xlabel="decisions, millions")
        deviation.set(ylabel="mean deviation, m", xlabel="decisions, millions")
        rate.figure.legend(*rate.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure.standalone(drawing.markup)


def ship(run: Path, name: str, limits: str = "", into: Path = FOLDER, encounters: int = 0) -> Path:
    """Make the folder of a shipped agent.

    Parameters
    ----------
    run : Path
        Folder of a finished run.
    name : str
        The name of the agent.
    limits : str
        Markdown for the card: what is known to go wrong.
    into : Path
        Where the folder goes.
    encounters : int
        To choose the seed on; 0: it is the run's own agent.

    Raises
    ------
    ParamsError
        For another name, or a run that is not finished.
    """
    if not NAME.fullmatch(name):
        raise ParamsError(f"name {name!r} must be small letters, digits and hyphens, such as ppo-plane")
    recipe, document = runs.read(run)
    seeds = seeds_of(run, recipe, document["seeds"])
    if encounters:
        shipped, *_ = flown = flown_again(seeds, recipe, encounters)
        seeds = sorted(flown, key=lambda seed: seed.number)
    else:
        digest = load(run / AGENT, recipe.params).digest
        own = [seed for seed in seeds if seed.agent.digest == digest]
        if not own:
            raise ParamsError(f"{run / AGENT} is not the best policy of one of its seeds; go on with the run first")
        shipped = own[0]
    into.mkdir(exist_ok=True)
    with replaced_folder(into / name) as folder:
        copy_policy(shipped.folder, folder)
        write_text(folder / CARD, card(name, recipe, document, seeds, shipped, limits))
        write_text(folder / CURVES, curves(seeds))
        write_text(folder / CHART, chart(seeds, shipped))
    return into / name


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Makes the folder of a shipped agent from a finished run.")
    parser.add_argument("run", type=Path, metavar="RUN")
    parser.add_argument("--name", required=True)
    parser.add_argument("--limits", type=Path, metavar="FILE", help="Markdown for the card's limits")
    parser.add_argument("--encounters", type=int, default=0, metavar="N", help="choose the seed on so many")
    options = parser.parse_args()
    limits = options.limits.read_text(encoding="utf-8") if options.limits else ""
    try:
        print(ship(options.run, options.name, limits, encounters=options.encounters))
    except ParamsError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
