"""Same key, same encounter and noise.

A row of a batch is the single environment, bit for bit, and no policy changes the noise.
"""

import functools
from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest

from rss_gym.core import INFO
from rss_gym.env import EncounterEnv
from rss_gym.vector import EncounterVectorEnv

SEED = 1000
# Rows of a batch -> resets and decisions flown by each row; an episode is at most 211 of them.
EVENTS = {1: 750, 2: 750, 7: 750, 64: 320}
COLUMNS = (*INFO, "is_success")
RESET, STEP = 0, 1
# Besides every id on every level of information, whatever adds records or draws.
VARIANTS = {
    "latest": {"tracker": "latest", "estimator": "ekf-white-r"},
    "late and lost messages": {"message_latency_s": 0.7, "message_loss": 0.3, "announce_s": 8.0, "intruders": 3},
    "late ranges": {"information": "ranges", "message_latency_s": 0.5, "intruders": 2},
    "shaped": {"shaping_m": 50.0, "proximity_price_m": 5.0},
    "discrete": {"action": "discrete", "planar": False},
    "intruders": {"intruders": 4, "intruders_min": 1, "planar": False},
    "complications": {"families": ["late-turn", "deceitful", "path-loss-jump", "outage", "merging"], "intruders": 3},
    "radio": {"channel": ["quadcopter", {"packet_loss": 0.2}], "estimator": "ls", "agent": "gnss", "zone": "adaptive"},
}
WORLDS = {
    **{
        f"{name}-{information}": (name, {"information": information})
        for name in ("Encounter-v0", "Encounter3D-v0", "EncounterRangeOnly-v0")
        for information in ("oracle", "positions", "ranges")
    },
    **{name: ("Encounter-v0", keywords) for name, keywords in VARIANTS.items()},
}


@functools.cache
def actions_of(row, axes):
    """A row's actions, by the number of its own decision: held for eight of them, so that flights differ."""
    generator = np.random.default_rng([row, axes])
    if axes == 0:  # discrete
        held = generator.integers(9, size=100)
    else:
        held = generator.uniform(-1.2, 1.2, (100, axes)).astype(np.float32)
    return held.repeat(8, axis=0)


def axes_of(space):
    return 0 if isinstance(space, gym.spaces.Discrete) else space.shape[0]


def columns(info):
    return np.array([info[name] for name in COLUMNS], np.float64)


@functools.cache
def single_flight(world, row):
    """What a single environment returns from seed `SEED + row` on: its resets and decisions, one after the other."""
    name, keywords = WORLDS[world]
    env = gym.make(f"rss_gym/{name}", **keywords).unwrapped
    actions, events, number, running = actions_of(row, axes_of(env.action_space)), [], 0, False
    while len(events) < max(length for n, length in EVENTS.items() if row < n):
        if running:
            observation, reward, terminated, truncated, info = env.step(actions[number])
            number += 1
        else:
            observation, info = env.reset(seed=None if events else SEED + row)
            reward, terminated, truncated = 0.0, False, False
        events.append((STEP if running else RESET, observation, reward, terminated, truncated, columns(info)))
        running = not (terminated or truncated)
    return [np.array(part) for part in zip(*events, strict=True)]


def single_flights(world, n):
    """The first `n` of them, as arrays (rows, events, ...)."""
    names = ("kind", "observation", "reward", "terminated", "truncated", "info")
    flights = zip(*(single_flight(world, row) for row in range(n)), strict=True)
    return SimpleNamespace(
        **{name: np.stack([part[: EVENTS[n]] for part in parts]) for name, parts in zip(names, flights, strict=True)}
    )


def same(value, expected):
    """Equal bit for bit, with the same type and shape."""
    value, expected = np.asarray(value), np.asarray(expected)
    return value.shape == expected.shape and value.dtype == expected.dtype and value.tobytes() == expected.tobytes()


@pytest.mark.parametrize("n", [pytest.param(n, marks=[pytest.mark.slow] * (n != 7)) for n in EVENTS])
@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
@pytest.mark.parametrize("world", WORLDS)
def test_rows_are_single_environments(world, mode, n):
    """Through automatic resets that fall on different steps."""
    expected = single_flights(world, n)
    name, keywords = WORLDS[world]
    envs = gym.make_vec(f"rss_gym/{name}", num_envs=n, autoreset_mode=mode, **keywords)
    rows = np.arange(n)
    actions = np.stack([actions_of(row, axes_of(envs.single_action_space)) for row in rows], axis=1)
    at, flown, reset_steps = np.zeros(n, int), np.zeros(n, int), set()

    def check(got, observation, infos, rows, at):
        for part, values in got.items():
            assert same(values, getattr(expected, part)[rows, at]), part
        assert same(observation, expected.observation[rows, at])
        assert same(np.stack([infos[c][rows].astype(float) for c in COLUMNS], axis=-1), expected.info[rows, at])

    observation, infos = envs.reset(seed=SEED)
    check({}, observation, infos, rows, at)
    for step in range(EVENTS[n]):
        if at.max() >= EVENTS[n] - 2:  # an ended row may go two events on
            break
        observation, reward, terminated, truncated, infos = envs.step(actions[flown, rows])
        at += 1
        kind = expected.kind[rows, at]
        flown += kind == STEP
        got = {"reward": reward, "terminated": terminated, "truncated": truncated}
        ended = terminated | truncated
        if mode == "SameStep" and ended.any():
            final = np.where(ended)[0]
            assert (infos["_final_obs"] == ended).all() and (infos["_final_info"] == ended).all()
            assert all(value is None for value in infos["final_obs"][~ended])
            check({}, np.stack(infos["final_obs"][final]), infos["final_info"], final, at[final])
            for part, values in got.items():
                assert same(values, getattr(expected, part)[rows, at]), part
            at += ended
            check({}, observation, infos, rows, at)
        else:
            check(got, observation, infos, rows, at)
        if mode == "Disabled" and ended.any():
            mask = ended.copy()
            options = {"reset_mask": mask}
            before = observation.copy()
            observation, infos = envs.reset(options=options)
            assert options == {"reset_mask": mask} and (mask == ended).all()
            at += ended
            check({}, observation[ended], infos, rows[ended], at[ended])
            assert same(observation[~ended], before[~ended])
            assert (infos["_collision"] == ended).all()
        if ended.any():
            reset_steps.add(step)
    # The case is worth something: several resets of each row, on different steps.
    assert len(reset_steps) >= 3
    for row in rows:
        assert (expected.kind[row, : at[row] + 1] == RESET).sum() - 1 >= (3 if n <= 7 else 1)


def test_references_contain_both_ends():
    flights = single_flights("Encounter-v0-positions", 64)
    assert flights.terminated.any() and flights.truncated.any()


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_batch_size_and_neighbours_do_not_matter(mode):
    """The same seed in two places of two batches, among others."""
    one = EncounterVectorEnv(3, autoreset_mode=mode)
    two = EncounterVectorEnv(5, autoreset_mode=mode)
    one.reset(seed=[7, 8, 9])
    two.reset(seed=[1, 9, 2, 7, 3])
    generator = np.random.default_rng(0)
    for _ in range(400):
        a = generator.uniform(-1, 1, (5, 2))
        r1, r2 = one.step(a[[3, 0, 1]]), two.step(a)
        for x, y in zip(r1[:-1], r2[:-1], strict=True):
            assert same(x[[0, 2]], y[[3, 1]])


@pytest.mark.parametrize(
    "keywords",
    [{}, {"intruders": 3}, {"agent": "gnss", "planar": False}, {"information": "ranges"}],
    ids=lambda k: "-".join(k),
)
def test_policies_meet_the_same_noise(keywords):
    """At every tick (a decision of one tick shows them all) the channel and the gusts are the same, the flights not."""
    keywords = {"decision_s": 0.1, **keywords}
    still, busy = EncounterEnv(**keywords), EncounterEnv(**keywords)
    for seed in range(4):
        still.reset(seed=seed)
        busy.reset(seed=seed)
        generator = np.random.default_rng(seed)
        for tick in range(1, 400):
            a = still.step(np.zeros(still.action_space.shape))
            b = busy.step(generator.choice([-1.0, 1.0], busy.action_space.shape))
            if a[2] or a[3] or b[2] or b[3]:
                break
            one, two = still.batch.state, busy.batch.state
            assert one.episode["key"] == two.episode["key"]
            present = int(one.episode["intruders"][0])
            assert same(one.tick_normals, two.tick_normals)
            assert same(one.decision_normals, two.decision_normals)
            for column in ("coloured_db", "wander"):
                assert same(one.links[column], two.links[column])
            for column in ("gust_mps", "gnss_error_m", "velocity_error_mps", "barometer_error_m", "planned_m"):
                assert same(one.aircraft[column][:, : 1 + present], two.aircraft[column][:, : 1 + present]) or (
                    column == "planned_m" and "information" in keywords  # a hover shifts an intruder's clock
                )
            if tick > 5:
                assert (one.aircraft["position_m"][0, 0, :2] != two.aircraft["position_m"][0, 0, :2]).all()
        assert tick > 100


def test_noise_does_not_depend_on_the_rest_of_the_world():
    """Link 0, the first encounter and the agent's errors: whatever the number of intruders and the localisation."""
    worlds = [
        {},
        {"intruders": 2},
        {"intruder": "gnss"},
        {"agent": "gnss"},
        {"information": "oracle", "estimator": "ls"},
    ]
    envs = [EncounterEnv(decision_s=0.1, **keywords) for keywords in worlds]
    for seed in range(3):
        for env in envs:
            env.reset(seed=seed)
        for _ in range(200):
            results = [env.step(np.zeros(2)) for env in envs]
            if any(r[2] or r[3] for r in results):
                break
            first = envs[0].batch.state
            for env in envs[1:]:
                state = env.batch.state
                assert same(state.links["coloured_db"][0, 0], first.links["coloured_db"][0, 0])
                assert same(state.links["wander"][0, 0], first.links["wander"][0, 0])
                # Errors of GNSS are drawn on only where there is any.
                for column in ("gust_mps", "path_m", "path_s", "planned_m"):
                    assert same(state.aircraft[column][0, 1], first.aircraft[column][0, 1]) or column in (
                        "path_m",
                        "path_s",
                    )
                    assert same(state.aircraft[column][0, 0], first.aircraft[column][0, 0]) or column in (
                        "path_m",
                        "path_s",
                    )
