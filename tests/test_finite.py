"""A state that is not finite is an error of the run, named; no permitted parameter makes one."""

import warnings

import numpy as np
import pytest

from rss_gym import encounters
from rss_gym.core import Batch, NotFiniteError
from rss_gym.env import EncounterEnv
from rss_gym.params import Params
from rss_gym.vector import EncounterVectorEnv

FAMILIES = [name for name, family in encounters.FAMILIES.items() if family.script is None]
SCRIPTED = [name for name, family in encounters.FAMILIES.items() if family.script is not None]
NO_TAIL = {"tail_min_s": 0.0, "tail_max_s": 0.0}


def all_finite(state):
    """Every number of the rows that are present."""
    for i, e in enumerate(state.episode):
        k = int(e["intruders"])
        for records in (state.episode[i], state.aircraft[i, : 1 + k], state.links[i, :k], state.contacts[i, :k]):
            for name in records.dtype.names:
                part = records[name]
                if part.dtype.kind == "f" and not np.isfinite(part).all():
                    return False
    return True


@pytest.mark.parametrize("intruders", [1, 2, 8])
@pytest.mark.parametrize("family", [*FAMILIES, "mixed"])
def test_flights_that_end_at_the_closest_approach(family, intruders):
    params = Params.of(families=family, intruders=intruders, planar=intruders != 2, announce_s=60.0, **NO_TAIL)
    batch = Batch(params, 16)
    batch.seed(np.arange(16, dtype=np.uint64))
    batch.reset(np.ones(16, bool))
    assert all_finite(batch.state) and np.isfinite(batch.observations).all()
    ended, generator = np.zeros(16, bool), np.random.default_rng(0)
    while not ended.all():
        batch.step(generator.uniform(-1, 1, (16, 3)), ~ended)
        assert np.isfinite(batch.observations).all() and np.isfinite(batch.rewards).all()
        ended |= batch.episode["terminated"] | batch.episode["truncated"]
    assert all_finite(batch.state)


@pytest.mark.parametrize("intruders", range(1, 9))
def test_merging_without_a_tail(intruders):
    env = EncounterVectorEnv(16, families="merging", intruders=intruders, **NO_TAIL)
    assert np.isfinite(env.reset(seed=0)[0]).all()
    for _ in range(60):
        observations, rewards, *_ = env.step(np.zeros((16, 2)))
        assert np.isfinite(observations).all() and np.isfinite(rewards).all()
    assert all_finite(env.batch.state)


@pytest.mark.parametrize("family", SCRIPTED)
def test_written_encounters(family):
    env = EncounterVectorEnv(4, families=family, information="ranges", **NO_TAIL)
    assert np.isfinite(env.reset(seed=0)[0]).all()
    for _ in range(60):
        assert np.isfinite(env.step(np.zeros((4, 2)))[0]).all()
    assert all_finite(env.batch.state)


BREAKS = {
    "position": lambda state, row: state.aircraft[row, 0]["position_m"].__setitem__(1, np.nan),
    "velocity of the intruder": lambda state, row: state.aircraft[row, 1]["velocity_mps"].__setitem__(0, np.nan),
    "solution": lambda state, row: state.aircraft[row, 0]["solution_m"].__setitem__(0, np.inf),
    "range": lambda state, row: state.links[row].__setitem__("range_m", np.nan),
}


def sb3(n, **keywords):
    return pytest.importorskip("rss_gym.sb3").EncounterVecEnv(n, **keywords)


@pytest.mark.parametrize("name", BREAKS)
@pytest.mark.parametrize("kind", ["single", "vector", "sb3"])
def test_a_state_made_not_finite_is_named(kind, name):
    row, seed = (0, 41) if kind == "single" else (2, 43)
    if kind == "single":
        env = EncounterEnv()
        env.reset(seed=41, options={"split": "validation", "episode": 6})
    elif kind == "vector":
        env = EncounterVectorEnv(3)
        env.reset(seed=41, options={"split": "validation", "episode": [6, 6, 6]})
    else:
        env = sb3(3)
        env.seed(41)
        env.set_options({"split": "validation", "episode": 6})
        env.reset()
    actions = np.zeros(env.action_space.shape) if kind != "sb3" else np.zeros((3, 2))
    for _ in range(3):
        env.step(actions)
    BREAKS[name](env.batch.state, row)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        with pytest.raises(NotFiniteError, match=rf"episode 6 of seed {seed}, split 'validation'") as caught:
            env.step(actions)
    assert (caught.value.split, caught.value.seed, caught.value.episode) == ("validation", seed, 6)
    assert "\n" not in str(caught.value)


def test_the_error_travels_between_processes():
    import pickle

    error = NotFiniteError("suite", 930000101, 12)
    twin = pickle.loads(pickle.dumps(error))
    assert str(twin) == str(error) and twin.episode == 12
