"""A run on a road: `run.json`, a folder a seed with its curves and its best driver, in the end `agent/` with a card."""

from __future__ import annotations

import contextlib
import functools
import json
import multiprocessing
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rss_gym.baselines.road import World, make
from rss_gym.baselines.shipped import CARD
from rss_gym.files import check_new, write_text
from rss_gym.params import ParamsError
from rss_gym.train.road.recipe import RoadRecipe
from rss_gym.train.run_record import AGENT, BEST, FORMAT, RUN, check_count, copy_policy, revision, versions

if TYPE_CHECKING:
    from rss_gym.train.road.learner import Score


def start(
    recipe: RoadRecipe, out: str | os.PathLike[str], seeds: int = 1, workers: int = 1, command: Sequence[str] = ()
) -> Path:
    """Train a recipe into the new folder `out`.

    Parameters
    ----------
    recipe : RoadRecipe
    out : path
        New folder.
    seeds : int
        Trainings that differ in their seed only.
    workers : int
        Processes, each with one seed at a time.
    command : sequence of str
        Kept in the run.

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
    folder = check_new(out)
    _check(recipe)
    try:
        import stable_baselines3  # noqa: F401
    except ImportError as error:
        raise ParamsError(f"training needs stable_baselines3 ({error}): pip install 'rss-gym[train]'") from error
    record: dict[str, Any] = {
        "name": recipe.name,
        "recipe": recipe.to_dict(),
        "versions": versions("highway-env", "torch", "stable-baselines3"),
        "revision": revision(),
    }
    document = {"format": FORMAT, **record, "seeds": seeds, "command": list(command)}
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / RUN, json.dumps(document, indent=1, allow_nan=False) + "\n")
    task = functools.partial(_seed, recipe, folder, record)
    if min(workers, seeds) == 1:
        scores = [task(index) for index in range(seeds)]
    else:
        with ProcessPoolExecutor(min(workers, seeds), multiprocessing.get_context("spawn")) as pool:
            scores = list(pool.map(task, range(seeds)))
    best = min(range(seeds), key=lambda index: scores[index].cost_m)
    (folder / AGENT).mkdir()
    copy_policy(folder / f"seed-{best}" / BEST, folder / AGENT)
    write_text(folder / AGENT / CARD, card(recipe, record, scores, best))
    print(f"agent: {folder / AGENT}", flush=True)
    return folder / AGENT


def _check(recipe: RoadRecipe) -> None:
    """Refuse a road that cannot be made or trained on, and a driver that cannot be imitated on it."""
    with contextlib.closing(recipe.environment()) as env:
        env.reset(seed=0)
        world = World.of(env)
        if not world.actions:
            raise ParamsError(f"[world]: only highway-env's meta-actions can be learnt, got {env.action_space}")
        make(recipe.imitation.policy, world)


def _seed(recipe: RoadRecipe, folder: Path, record: dict[str, Any], index: int) -> Score:
    from rss_gym.train.road.learner import train_seed

    return train_seed(recipe, folder / f"seed-{index}", index, record)


def card(recipe: RoadRecipe, record: dict[str, Any], scores: Sequence[Score], best: int) -> str:
    """What a driver was trained on, how its seeds did, and what it is not for."""
    env = recipe.environment()
    information, zone_m = env.params.interface.information, env.params.zone.radius_m
    sees = "ranges and messages of the nearest vehicles" if recipe.radio else "no other vehicle"
    table = recipe.imitation
    first = (
        f" after imitating `{table.policy}`, which sees the vehicles, in {table.episodes} episodes"
        if table.episodes
        else ""
    )
    rows = "\n".join(
        f"| {index} | {score.steps:,} | {score.collision_rate:.3f} | {score.snmac_rate:.3f} "
        f"| {score.deviation_m:.1f} | {score.cost_m:.1f} |"
        for index, score in enumerate(scores)
    )
    return f"""# Driver `{recipe.name}`, seed {best} of {len(scores)}

Trained by PPO for {recipe.head.steps:,} decisions on `{recipe.head.env}`{first} ({env.scene.summary}).
It sees {sees}, and its own lane, speed and plan. Information `{information}`, zone {zone_m:g} m.
Recipe, versions and revision are in `policy.json`; revision {record["revision"]}.

Best validation of each seed, over the same {recipe.validation.episodes} episodes of split `validation`. The best is
chosen by its mean cost, which flatters it: scores on split `suite` are what counts. After 0 decisions it only imitates.

| seed | decisions | collisions | near misses | mean deviation, m | mean cost, m |
|---|---|---|---|---|---|
{rows}

Limits: this road, its traffic and its channel only, one decision a second, in a simulation. It says nothing about a
vehicle on a real road.
"""
