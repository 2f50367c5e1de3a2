"""A run: a folder with its recipe, one folder a seed, and in the end the best seed's agent.

```
run.json          recipe with every default, the world, seeds, versions, Git revision, command
seed-K/           progress.csv, validation.csv, tensorboard/, checkpoint/, best/ (a policy folder), best.zip (SB3's)
agent/            the best seed's policy folder
```
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gymnasium.spaces import Discrete

from rss_gym import registry
from rss_gym.baselines.agent import Agent, load
from rss_gym.baselines.policy_files import DOCUMENT
from rss_gym.core import SEED_LIMIT
from rss_gym.domain import ROAD
from rss_gym.eval.processes import interrupts_held, process_pool
from rss_gym.files import check_new, new_folder, replaced_folder, tidy, write_text
from rss_gym.params import ParamsError
from rss_gym.plain_files import read_json
from rss_gym.schema import Schema, checked, listed, optional, table, text, version, whole
from rss_gym.train import recipe as recipes
from rss_gym.train.hyperparameters import ALGORITHMS
from rss_gym.train.lock import locked
from rss_gym.train.recipe import Recipe
from rss_gym.train.run_record import AGENT, BEST, COUNT_MAX, FORMAT, RUN, check_count, copy_policy, revision, versions

if TYPE_CHECKING:
    from rss_gym.train.loop import Times

LOCK = "lock"
RUN_BYTES_MAX = 1 << 22
FIELDS: Schema = {
    "format": version(FORMAT),
    "name": text(),
    "recipe": table("a table, the recipe with every default"),
    "world": table("a table, the parameters of the world"),
    "seeds": listed(1, COUNT_MAX, f"a list of 1 to {COUNT_MAX} whole numbers", whole(0, SEED_LIMIT - 1)),
    "versions": table("a table of package names and versions"),
    "revision": optional(text()),
    "command": listed(0, 10**6, "a list of texts", text()),
}


def start(
    recipe: Recipe,
    out: str | os.PathLike[str],
    seeds: int = 1,
    workers: int = 1,
    command: Sequence[str] = (),
    show: bool | None = None,
) -> Path:
    """Train a recipe into the new folder `out`.

    Parameters
    ----------
    recipe : Recipe
    out : path
        New folder.
    seeds : int
        Trainings that differ in their seed only, k * 2**20 for k from 0.
    workers : int
        Processes, each with one seed at a time.
    command : sequence of str
        Kept in the run.
    show : bool, optional
        Show progress bars; default: on a terminal, elsewhere a line every half a minute.

    Returns
    -------
    Path
        The policy folder of the best seed.

    Raises
    ------
    ParamsError
        For numbers out of range, a folder that exists, or packages that are missing.
    """
    check_count("seeds", seeds)
    check_count("workers", workers)
    check_new(out)
    _loop(recipe)
    with new_folder(out) as folder:
        write_text(folder / RUN, json.dumps(_document(recipe, seeds, command), indent=1, allow_nan=False) + "\n")
        for index in range(seeds):
            (folder / f"seed-{index}").mkdir()
    return _train(Path(out), workers, show)


def resume(folder: str | os.PathLike[str], workers: int = 1, show: bool | None = None) -> Path:
    """Go on with a run from the checkpoints of its seeds; seeds that are done stay as they are.

    Raises
    ------
    ParamsError
        If this is not the folder of a run, another process trains it, or its world is another one today.
    """
    check_count("workers", workers)
    _loop(read(folder)[0])
    return _train(Path(folder), workers, show)


def read(folder: str | os.PathLike[str]) -> tuple[Recipe, dict[str, Any]]:
    """A run's recipe and its `run.json`.

    Raises
    ------
    ParamsError
        As `resume`.
    """
    try:
        document = read_json(Path(folder) / RUN, RUN_BYTES_MAX)
        checked("", "", document, FIELDS)
        recipe = recipes.from_dict(document["name"], document["recipe"])
    except ParamsError as error:
        raise ParamsError(f"{str(folder)!r} is not the folder of a run: {RUN}: {error}") from error
    if recipe.params.to_dict() != document["world"]:
        raise ParamsError(
            f"{str(folder)!r} was begun in a world that this version of rss-gym has other numbers for; go on with the "
            f"version it was begun with, {document['versions'].get('rss-gym')}"
        )
    return recipe, document


def best_seed(folder: str | os.PathLike[str]) -> tuple[Path, str]:
    """The best policy folder among the seeds, all flown once more over the same encounters; and the table of seeds.

    Raises
    ------
    ParamsError
        If no seed has been validated yet.
    """
    from rss_gym.train.validation import Validator, closing_sentence, ranked

    recipe, document = read(folder)
    root = Path(folder)
    validator = Validator(recipe.params, recipe.validation.episodes)
    found = {
        name: load(root / name / BEST, recipe.params)
        for name in (f"seed-{index}" for index in range(len(document["seeds"])))
        if (root / name / BEST / DOCUMENT).exists()
    }
    if not found:
        raise ParamsError(f"run {str(folder)!r} has no agent yet: its first validation is still to come")
    scores = {name: validator.score(agent, name) for name, agent in found.items()}
    places = ranked(scores)
    if places[0].place is None:
        raise ParamsError(f"run {str(folder)!r} has no agent to rank: each gave actions that are not finite")
    lines = [f"{recipe.validation.episodes} encounters of split validation, 95 % intervals; best first:"]
    for place in places:
        steps = training_record(found[place.name], "validation", "steps")
        number = "-" if place.place is None else f"{place.place}."
        lines.append(f"  {number} {place.name}, {steps:,} steps: {scores[place.name]}")
    best = places[0].name
    lines.append(closing_sentence(root / best, scores[best], validator))
    return root / best / BEST, "\n".join(lines)


def training_record(agent: Agent, *keys: str) -> Any:
    """A number of an agent's training record.

    Raises
    ------
    ParamsError
        If the record does not have it.
    """
    found: Any = agent.document["training"]
    for key in keys:
        found = found.get(key) if isinstance(found, dict) else None
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        raise ParamsError(f"the agent's {DOCUMENT} has no training record: training.{'.'.join(keys)} must be a number")
    return found


def _loop(recipe: Recipe) -> None:
    """Refuse to begin without the learner's package, or with actions that cannot be learnt."""
    action = recipe.domain.spaces(recipe.params)[1]
    if recipe.domain is ROAD and not isinstance(action, Discrete):
        raise ParamsError(f"[world]: only highway-env's meta-actions can be learnt, got {action}")
    module = ALGORITHMS[recipe.algorithm].module
    try:
        __import__(module)
    except ImportError as error:
        raise ParamsError(
            f"training needs {error.name or module} ({error}): pip install -e '.[train]' in the clone"
        ) from error


def _document(recipe: Recipe, seeds: int, command: Sequence[str]) -> dict[str, Any]:
    from rss_gym.train.loop import SEED_STRIDE

    return {
        "format": FORMAT,
        "name": recipe.name,
        "recipe": recipe.to_dict(),
        "world": recipe.params.to_dict(),
        "seeds": [index * SEED_STRIDE for index in range(seeds)],
        "versions": versions("torch", "stable-baselines3", "sb3-contrib", *recipe.domain.packages),
        "revision": revision(),
        "command": list(command),
    }


def _train(folder: Path, workers: int, show: bool | None) -> Path:
    from rss_gym.train.loop import has_tensorboard

    with locked(folder / LOCK):
        _, document = read(folder)
        tidy(folder, AGENT)
        if not has_tensorboard():
            print("TensorBoard is not installed (pip install tensorboard): curves go to progress.csv only", flush=True)
        count = len(document["seeds"])
        if min(workers, count) == 1:
            for index in range(count):
                _report(index, _seed(str(folder), index, show))
        else:
            _spread(folder, count, workers, show)
        best, table = best_seed(folder)
        with replaced_folder(folder / AGENT) as new:
            copy_policy(best, new)
        print(f"{table}\nagent: {folder / AGENT}", flush=True)
    return folder / AGENT


def _report(index: int, times: Times) -> None:
    print(f"seed {index}: {times}", flush=True)


def _seed(folder: str, index: int, show: bool | None, position: int = 0, sent: bytes = b"") -> Times:
    from rss_gym.train.loop import train_seed

    registry.restore(sent)
    recipe, document = read(folder)
    record = {key: document[key] for key in ("name", "recipe", "versions", "revision")}
    return train_seed(recipe, Path(folder) / f"seed-{index}", index, record, show, position)


def _spread(folder: Path, count: int, workers: int, show: bool | None) -> None:
    """Train the seeds in processes of their own, which end with this one."""
    try:
        with process_pool(min(workers, count)) as pool:
            sent = registry.added()
            with interrupts_held():
                seeds = {pool.submit(_seed, str(folder), index, show, index, sent): index for index in range(count)}
            for seed in as_completed(seeds):
                _report(seeds[seed], seed.result())
    except BrokenProcessPool as error:
        raise ParamsError(
            f"a process that trained a seed died (out of memory, or killed); go on with --resume {folder}"
        ) from error
