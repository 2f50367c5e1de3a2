"""What every environment must keep, whatever its id, information and kind of action."""

import copy
import importlib
import itertools
import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.utils.passive_env_checker import data_shares_objects
from gymnasium.vector import AutoresetMode

from rss_gym.core import INFO
from rss_gym.env import EncounterEnv
from rss_gym.ids import IDS as REGISTERED
from rss_gym.ids import ROADS
from rss_gym.params import Params
from rss_gym.vector import EncounterVectorEnv

IDS = tuple(REGISTERED)
CHANNELS = ["paper", "quadcopter", {"path_loss_factor": 3.0, "packet_loss": 0.2}]

pytestmark = pytest.mark.usefixtures("no_warnings")


def end(env, step):
    """Fly `step(number)` until the episode ends; returns the transitions."""
    transitions = []
    while not transitions or not (transitions[-1][2] or transitions[-1][3]):
        transitions.append(env.step(step(len(transitions))))
    return transitions


def extreme(space, generator):
    """Valid actions as large as can be."""
    if isinstance(space, gym.spaces.Discrete):
        return int(generator.integers(space.n))
    return generator.choice([-1e300, -1.0, -0.0, 1e-300, 1.0, 1e300], space.shape)


# -- checkers ---------------------------------------------------------------------------------------------------------


def test_ids_are_all(request):
    """The fixture `env_id` goes through the registry."""
    conftest = next(plugin for plugin in request.config.pluginmanager.get_plugins() if hasattr(plugin, "ACTIONS"))
    assert conftest.IDS == IDS
    assert {*IDS, *ROADS} == {name for name in gym.registry if name.startswith("rss_gym/")}


def test_gymnasium_check_env(env_id, information, action):
    env = gym.make(env_id, information=information, action=action).unwrapped
    check_env(env, skip_render_check=True)
    env.close()


def test_gymnasium_check_env_with_render_modes(env_id):
    pytest.importorskip("pygame")
    env = gym.make(env_id, render_mode="rgb_array").unwrapped
    check_env(env)
    env.close()


def test_sb3_check_env(env_id, information, action):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    for env in (
        EncounterEnv(**REGISTERED[env_id] | {"information": information, "action": action}),
        gym.make(env_id, information=information),
    ):
        checker.check_env(env, warn=True)


def test_default_wrappers_pass_data_on(env_id, information, action):
    """`gym.make` checks what is returned and warns; here a warning is an error."""
    env = gym.make(env_id, information=information, action=action)
    env.reset(seed=0)
    end(env, lambda _: env.action_space.sample())


# -- spec and pickle --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["pickle", "deepcopy"])
def test_copy_goes_on_alike(env_id, information, action, how):
    env = gym.make(env_id, information=information, action=action, channel=CHANNELS, intruders=2)
    env.action_space.seed(1)
    env.reset(seed=3)
    for _ in range(20):
        env.step(env.action_space.sample())
    twin = pickle.loads(pickle.dumps(env)) if how == "pickle" else copy.deepcopy(env)
    assert twin.unwrapped.params == env.unwrapped.params
    steps = [env.action_space.sample() for _ in range(20)]
    for a in steps:
        assert data_equivalence(env.step(a), twin.step(a), exact=True)
    assert data_equivalence(env.reset(), twin.reset(), exact=True)


def test_fresh_copy_starts_alike(env_id):
    """An environment that was never reset travels too, as `SubprocVecEnv` sends it."""
    env = pickle.loads(pickle.dumps(gym.make(env_id)))
    assert data_equivalence(env.reset(seed=1), gym.make(env_id).reset(seed=1), exact=True)


def test_vector_pickle_goes_on_alike(env_id):
    envs = gym.make_vec(env_id, num_envs=3)
    envs.reset(seed=5)
    envs.action_space.seed(0)
    for _ in range(5):
        envs.step(envs.action_space.sample())
    twin = pickle.loads(pickle.dumps(envs))
    for _ in range(300):
        a = envs.action_space.sample()
        assert data_equivalence(envs.step(a), twin.step(a), exact=True)


@pytest.mark.parametrize(
    "keywords",
    [
        {},
        {"gust_mps": 0.125, "intruders": 2, "agent": "gnss", "intruder": "gnss"},
        {"channel": CHANNELS, "families": ["crossing", "head-on"]},
        {"params": Params.of(channel=CHANNELS, announce_s=7.0, collision_price_m=50.0, estimator="ls").to_dict()},
    ],
    ids=["default", "keywords", "list-of-channels", "params"],
)
def test_spec_round_trip(env_id, keywords):
    env = gym.make(env_id, **keywords)
    spec = EnvSpec.from_json(env.spec.to_json())
    assert spec == env.spec
    twin = gym.make(spec)
    assert twin.unwrapped.params == env.unwrapped.params
    assert data_equivalence(env.reset(seed=2), twin.reset(seed=2), exact=True)
    one, two = (e.step(e.action_space.sample() * 0) for e in (env, twin))
    assert data_equivalence(one, two, exact=True)
    # The numbers inside the environment go back in as well.
    again = gym.make(env_id, params=env.unwrapped.params.to_dict())
    assert again.unwrapped.params == env.unwrapped.params


# -- data -------------------------------------------------------------------------------------------------------------


def test_fresh_objects(env_id, information, action):
    env = gym.make(env_id, information=information, action=action)
    results = [env.reset(seed=0)]
    kept = copy.deepcopy(results)
    for _ in range(30):
        observation, _, terminated, truncated, info = env.step(env.action_space.sample())
        results.append((observation, info))
        kept.append(copy.deepcopy(results[-1]))
        if terminated or truncated:
            break
    results.append(env.reset())
    kept.append(copy.deepcopy(results[-1]))
    for one, two in itertools.pairwise(results):
        assert not data_shares_objects(one[0], two[0])
        assert one[1] is not two[1]
    assert data_equivalence(results, kept, exact=True)
    batch = env.unwrapped.batch
    for observation, _ in results:
        assert not np.shares_memory(observation, batch.observations)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_fresh_vector_objects(mode):
    envs = gym.make_vec(IDS[0], num_envs=4, autoreset_mode=mode)
    results = [envs.reset(seed=0)]
    for _ in range(400):
        results.append(envs.step(envs.action_space.sample()))
    kept = copy.deepcopy(results)
    envs.step(envs.action_space.sample())
    envs.reset()
    assert data_equivalence(results, kept, exact=True)
    for one, two in itertools.pairwise(results):
        assert not any(np.shares_memory(a, b) for a in one[:-1] for b in two[:-1])
        assert not data_shares_objects(one[-1], two[-1])
    for array in (envs.batch.observations, envs.batch.rewards, envs.batch.episode):
        assert not any(np.shares_memory(array, part) for part in results[-1][:-1])
        assert not any(np.shares_memory(array, part) for part in results[-1][-1].values() if part.dtype != object)


def test_observations_stay_in_their_space(env_id, information, action):
    env = gym.make(env_id, information=information, action=action).unwrapped
    generator = np.random.default_rng(0)
    lows, highs = [], []
    for episode in range(6):
        observation, _ = env.reset(seed=episode)
        flights = [observation]
        flights += [t[0] for t in end(env, lambda _: extreme(env.action_space, generator))]
        for observation in flights:
            assert observation.dtype == np.float32
            assert observation.shape == env.observation_space.shape
            assert observation in env.observation_space
        lows.append(np.min(flights, axis=0))
        highs.append(np.max(flights, axis=0))
    # The space is not idle: what it bounds does vary.
    moving = np.ptp([np.min(lows, axis=0), np.max(highs, axis=0)], axis=0) > 0
    assert moving.mean() > 0.7


@pytest.mark.parametrize(
    "keywords",
    [
        {"intruders": 2, "intruders_min": 1, "planar": False},
        {"agent": "gnss", "intruder": "gnss", "zone": "adaptive"},
        {"agent": "dead-reckoning", "intruder": "dead-reckoning", "planar": False},
        {"estimator": "ls", "channel": {"packet_loss": 0.9}},
        {"estimator": "ekf-white", "channel": {"quantisation_db": 20.0}},
        {"channel": {"sensitivity_dbm": 0.0}},
        {"channel": {"white_variance_db2": 400.0, "coloured_variance_db2": 400.0}, "estimator": "ls"},
        {"channel": {"white_variance_db2": 0.0, "coloured_variance_db2": 1e-6, "path_loss_wander": 0.0}},
        {"channel": {"path_loss_factor": 1.0, "path_loss_wander": 2.0}},
        {"channel": ["radios", "clean"], "tick_s": 0.01, "decision_s": 0.1},
        {"tail_min_s": 0.0, "tail_max_s": 0.0, "decision_s": 10.0},
        {"message_latency_s": 1.5, "message_loss": 0.5, "announce_s": 0.0},
        {"estimator": "ekf-white-r", "tracker": "latest", "intruders": 3},
    ],
    ids=lambda keywords: "-".join(keywords),
)
def test_no_nan_in_odd_worlds(keywords):
    envs = EncounterVectorEnv(16, **keywords)
    envs.reset(seed=0)
    generator = np.random.default_rng(0)
    with np.errstate(all="raise"):
        for _ in range(150):
            actions = np.array([extreme(envs.single_action_space, generator) for _ in range(16)])
            observations, rewards, terminated, truncated, infos = envs.step(actions)
            assert observations in envs.observation_space
            assert np.isfinite(rewards).all()
            assert not (terminated & truncated).any()
            assert all(np.isfinite(infos[name]).all() for name in INFO)
    state = envs.batch.state
    for records in (state.aircraft, state.links, state.contacts):
        for name in records.dtype.names:
            assert records.dtype[name].base.kind != "f" or np.isfinite(records[name]).all(), name


# -- the end of an episode --------------------------------------------------------------------------------------------


def test_ends(env_id, information):
    """A collision terminates, the clock truncates, never both; an info tells which."""
    env = gym.make(env_id, information=information).unwrapped
    collisions = clocks = 0
    for episode in range(100):
        _, info = env.reset(seed=0, options={"episode": episode})
        assert not info["collision"] and not info["is_success"]
        flight = end(env, lambda _: np.zeros(env.action_space.shape, np.float32))
        for _, reward, terminated, truncated, info in flight[:-1]:
            assert not terminated and not truncated and not info["collision"] and not info["is_success"]
            assert reward == pytest.approx(sum(info[name] for name in INFO if name.startswith("reward_")), abs=1e-12)
        _, reward, terminated, truncated, info = flight[-1]
        assert terminated != truncated
        assert terminated == info["collision"]
        assert truncated == info["is_success"]
        state = env.batch.episode[0]
        if terminated:
            collisions += 1
            assert info["min_separation_m"] < env.params.zone.collision_m
            assert info["reward_collision"] == -env.params.reward.collision_price_m
            assert info["reward_snmac"] in (0.0, -env.params.reward.snmac_price_m)
            assert info["cost_m"] >= env.params.reward.collision_price_m + env.params.reward.snmac_price_m
        else:
            clocks += 1
            assert len(flight) == state["ticks"] // env.params.clock.ticks_per_decision
            assert info["min_separation_m"] >= env.params.zone.collision_m
            tail_s, clock = state["ticks"] * 0.1 - state["approach_s"], env.params.clock
            assert clock.tail_min_s - 1e-9 <= tail_s < clock.tail_max_s + clock.decision_s
    assert collisions >= 5
    assert clocks >= 5


def test_length_does_not_depend_on_the_policy(env_id):
    """The clock is the encounter's, so that paired comparisons see flights of one length."""
    env = gym.make(env_id).unwrapped
    for seed in range(5):
        lengths = set()
        for sign in (-1.0, 0.0, 1.0):
            env.reset(seed=seed)
            flight = end(env, lambda _, sign=sign: np.full(env.action_space.shape, sign, np.float32))
            if flight[-1][3]:
                lengths.add(len(flight))
        assert len(lengths) <= 1


def test_info_has_the_columns(env_id):
    env = gym.make(env_id).unwrapped
    for info in (env.reset(seed=0)[1], env.step(env.action_space.sample())[4]):
        assert set(info) == {*INFO, "is_success"}
        assert all(type(value) is np.ndarray and value.shape == () for value in info.values())
        assert {value.dtype for value in info.values()} == {np.dtype(bool), np.dtype(np.float64)}


# -- the ways to make it ----------------------------------------------------------------------------------------------


def test_made_in_three_ways(env_id):
    one, two = gym.make(env_id), gym.make(f"rss_gym:{env_id}")
    envs = gym.make_vec(env_id, num_envs=2)
    assert type(one.unwrapped) is type(two.unwrapped) is EncounterEnv
    assert type(envs) is EncounterVectorEnv
    assert envs.spec.id == env_id
    assert envs.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert data_equivalence(one.reset(seed=4), two.reset(seed=4), exact=True)
    np.testing.assert_array_equal(envs.reset(seed=4)[0][0], one.reset(seed=4)[0])
    assert type(gym.make_vec(f"rss_gym:{env_id}", num_envs=2)) is EncounterVectorEnv
    again = gym.make_vec(envs.spec)
    assert data_equivalence(again.reset(seed=4), envs.reset(seed=4), exact=True)


def test_entry_points_are_strings():
    for name in IDS:
        spec = gym.spec(name)
        assert isinstance(spec.entry_point, str) and isinstance(spec.vector_entry_point, str)
        module, _, attribute = spec.entry_point.partition(":")
        assert getattr(importlib.import_module(module), attribute) is EncounterEnv


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_equals_gymnasiums_own_vector_environment(env_id, action, mode):
    """Observations, rewards, ends and infos, key by key, of `SyncVectorEnv` over single environments."""
    keywords = {"action": action, "tail_min_s": 5.0, "tail_max_s": 5.0}
    ours = gym.make_vec(env_id, num_envs=3, autoreset_mode=mode, **keywords)
    theirs = gym.make_vec(
        env_id, num_envs=3, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, **keywords
    )
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"]
    assert data_equivalence(ours.reset(seed=10), theirs.reset(seed=10), exact=True)
    ours.action_space.seed(0)
    resets = 0
    for _ in range(250):
        a = ours.action_space.sample()
        result = ours.step(a)
        assert data_equivalence(result, theirs.step(a), exact=True)
        ended = result[2] | result[3]
        resets += ended.sum()
        if mode == "Disabled" and ended.any():
            mask = ended.copy()
            options = {"reset_mask": mask}
            assert data_equivalence(ours.reset(options=options), theirs.reset(options={"reset_mask": mask}), exact=True)
            assert options == {"reset_mask": mask} and (mask == ended).all()
    assert resets >= 3


# -- wrappers ---------------------------------------------------------------------------------------------------------


def test_single_wrappers(env_id):
    env = gym.wrappers.RecordEpisodeStatistics(gym.make(env_id))
    env = gym.wrappers.NormalizeObservation(gym.wrappers.FrameStackObservation(env, 3))
    env.reset(seed=0)
    flight = end(env, lambda _: env.action_space.sample())
    assert flight[-1][4]["episode"]["l"] == len(flight)
    assert flight[-1][4]["episode"]["r"] == pytest.approx(sum(t[1] for t in flight))


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_vector_wrappers(env_id, mode):
    wrappers = gym.wrappers.vector
    envs = wrappers.RecordEpisodeStatistics(
        gym.make_vec(env_id, num_envs=4, tail_min_s=5.0, tail_max_s=5.0, autoreset_mode=mode)
    )
    envs = wrappers.RescaleAction(envs, np.full(envs.single_action_space.shape, -5.0, np.float32), np.float32(5.0))
    envs.reset(seed=0)
    seen, lengths, returns, running = 0, [], np.zeros(4), np.zeros(4, int)
    skip = np.zeros(4, bool)
    for _ in range(300):
        _, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
        running += ~skip
        returns += rewards
        ended = terminated | truncated
        skip = ended if mode == "NextStep" else np.zeros(4, bool)
        if ended.any():
            assert (infos["_episode"] == ended).all()
            np.testing.assert_array_equal(infos["episode"]["l"][ended], running[ended])
            np.testing.assert_allclose(infos["episode"]["r"][ended], returns[ended])
            seen += ended.sum()
            lengths += list(running[ended])
            running[ended], returns[ended] = 0, 0.0
    assert seen >= 4
    assert len(set(lengths)) > 1


def test_dict_info_to_list():
    envs = gym.wrappers.vector.DictInfoToList(gym.make_vec(IDS[0], num_envs=3))
    _, infos = envs.reset(seed=0)
    single = gym.make(IDS[0])
    for row, info in enumerate(infos):
        assert info == single.reset(seed=row)[1]


# -- rendering --------------------------------------------------------------------------------------------------------


def test_rgb_array(env_id, information):
    env = gym.make(env_id, information=information, render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    for _ in range(30):
        env.step(env.action_space.sample())
    second = env.render()
    assert first.dtype == second.dtype == np.uint8
    assert first.shape == second.shape and first.ndim == 3 and first.shape[2] == 3
    assert (first != second).any()
    assert not np.shares_memory(first, second)
    assert env.metadata["render_fps"] == 10


def test_rendering_does_not_touch_the_world(env_id):
    plain, drawn = gym.make(env_id), gym.make(env_id, render_mode="rgb_array")
    assert data_equivalence(plain.reset(seed=1), drawn.reset(seed=1), exact=True)
    for _ in range(10):
        a = plain.action_space.sample()
        drawn.render()
        assert data_equivalence(plain.step(a), drawn.step(a), exact=True)


def test_vector_render(env_id):
    envs = gym.make_vec(env_id, num_envs=3, render_mode="rgb_array")
    envs.reset(seed=0)
    envs.step(envs.action_space.sample())
    frames = envs.render()
    assert len(frames) == 3
    single = gym.make(env_id, render_mode="rgb_array")
    single.reset(seed=0)
    assert frames[0].shape == single.render().shape
    assert (frames[0] != frames[1]).any()
    envs.close()


@pytest.mark.slow
@pytest.mark.parametrize("vector", [False, True])
def test_record_video(tmp_path, vector):
    editor = pytest.importorskip("moviepy")
    pytest.importorskip("imageio_ffmpeg")
    if vector:
        env = gym.make_vec(IDS[1], num_envs=2, render_mode="rgb_array")
        env = gym.wrappers.vector.RecordVideo(
            env, str(tmp_path / "clips"), step_trigger=lambda t: t == 0, video_length=12
        )
    else:
        env = gym.make(IDS[1], render_mode="rgb_array")
        env = gym.wrappers.RecordVideo(env, str(tmp_path / "clips"), step_trigger=lambda t: t == 0, video_length=12)
    env.reset(seed=0)
    for _ in range(30):
        env.step(env.action_space.sample())
    env.close()
    (path,) = (tmp_path / "clips").glob("*.mp4")
    with editor.VideoFileClip(str(path)) as clip:
        assert clip.fps == pytest.approx(10)
        assert clip.duration == pytest.approx(1.2, abs=0.25)
        assert (clip.get_frame(0.05) != clip.get_frame(1.1)).any()
