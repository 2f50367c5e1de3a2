"""Compile every kernel of the package once, by calling each as the world, the policies and the libraries call it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from rss_gym import baselines, jit
from rss_gym.avoidance.literal import flown
from rss_gym.baselines.network import long_short_term
from rss_gym.params import Params, load_channel
from rss_gym.progress import progress_bar
from rss_gym.radio import simulate
from rss_gym.radio.path_loss import distance, received
from rss_gym.ranging.path_loss_factor import adaptive, estimate_path_loss_factor
from rss_gym.ranging.track import ESTIMATORS, track
from rss_gym.safety.counting import count_missed
from rss_gym.vector import EncounterVectorEnv


def warm(show: bool | None = None) -> Path | None:
    """Compile what is not compiled yet and keep it.

    Parameters
    ----------
    show : bool, optional
        Show a progress bar; default: on a terminal, elsewhere a line every half a minute.

    Returns
    -------
    Path or None
        The folder of compiled code; None if none can be kept.
    """
    parts = list(steps())
    with progress_bar(show, iterable=parts, unit="part") as bar:
        for name, call in bar:
            bar.set_description(name)
            call()
    folder: Path | None = jit.cache_dir(Path(__file__).resolve().parent)
    return folder


def steps() -> Iterator[tuple[str, Callable[[], object]]]:
    """Name and call of each part, in the order in which others need them."""
    yield "world", partial(_fly, "none", Params())
    done = set()
    for planar in (False, True):
        for level in baselines.LEVELS:
            world = Params.of(planar=planar, information=level)
            for name in baselines.able(world):
                if name not in done:
                    done.add(name)
                    yield f"policy {name}", partial(_fly, name, world)
    yield "recurrent agents", _recurrent
    channel = load_channel("paper")
    log = simulate(np.linspace(60.0, 30.0, 20), 0.1, channel)
    for name in ESTIMATORS:
        yield f"estimator {name}", partial(track, name, log.time_s, log.rss_dbm, channel)
    yield "path loss", lambda: (received(log.distance_m, channel), distance(log.rss_dbm, channel))
    yield "path loss factor", lambda: _path_loss_factor(log.distance_m, log.rss_dbm - channel.offset_dbm)
    yield "safety zone", lambda: count_missed(0.8, 3, 10)
    yield "rule", lambda: flown([[30.0, 0.0]], [[1.0, 0.0]], [[0.0, 0.0]], 60.0)
    if find_spec("highway_env") is not None:
        yield "roads", _drive


def _fly(name: str, world: Params) -> None:
    policy = baselines.make(name, world)
    flight = EncounterVectorEnv(2, params=policy.params)
    observations, _ = flight.reset(seed=0)
    actions, _ = policy.predict(observations)
    flight.step(actions)


def _recurrent() -> None:
    one, two = np.zeros((1, 4)), np.zeros((1, 2))
    long_short_term(one, one, np.zeros(4), np.zeros((1, 1)), two, np.zeros((1, 1)))


def _path_loss_factor(distance_m: np.ndarray, phi_db: np.ndarray) -> None:
    estimate_path_loss_factor(distance_m, phi_db)
    adaptive(distance_m, phi_db, 0.0, 5)


def _drive() -> None:
    from rss_gym.highway.env import RoadEnv

    road = RoadEnv()
    road.reset(seed=0)
    road.step(1)
    road.close()
