"""The VecEnv: SB3's contract, its wrappers, and equality with the Gymnasium vector environment."""

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="stable-baselines3 (extra `train`) is not installed")

from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecFrameStack, VecMonitor, VecNormalize, VecVideoRecorder

import rss_gym  # noqa: F401
from rss_gym.ids import IDS, ROADS
from rss_gym.observation import fields
from rss_gym.params import Params, ParamsError
from rss_gym.sb3 import make_vec_env

N = 6
FAST = {
    "tail_min_s": 0.0,
    "tail_max_s": 0.0,
    "start_range_min": 0.8,
    "start_range_max": 0.9,
}  # short flights, so that many end


def actions(rng, environment):
    return rng.uniform(-1, 1, (N, *environment.action_space.shape)).astype(np.float32)


@pytest.mark.parametrize("name", sorted(IDS))
def test_equals_the_vector_environment_bit_for_bit(name):
    ours = make_vec_env(name, N, seed=7, every_info=True, **FAST)
    theirs = gym.make_vec(name, num_envs=N, vectorization_mode="vector_entry_point", autoreset_mode="SameStep", **FAST)
    ours_seen, (theirs_seen, _) = ours.reset(), theirs.reset(seed=7)
    np.testing.assert_array_equal(ours_seen, theirs_seen)
    rng, ends = np.random.default_rng(0), 0
    for _ in range(150):
        act = actions(rng, ours)
        seen, rewards, dones, infos = ours.step(act)
        other, other_rewards, terminated, truncated, other_infos = theirs.step(act)
        np.testing.assert_array_equal(seen, other)
        np.testing.assert_array_equal(rewards, other_rewards.astype(np.float32))
        np.testing.assert_array_equal(dones, terminated | truncated)
        for row in np.flatnonzero(dones):
            ends += 1
            np.testing.assert_array_equal(infos[row]["terminal_observation"], other_infos["final_obs"][row])
            assert infos[row]["TimeLimit.truncated"] == bool(truncated[row] and not terminated[row])
            assert infos[row]["collision"] == other_infos["final_info"]["collision"][row]
    assert ends > N


def test_collision_is_no_time_limit():
    environment = make_vec_env("rss_gym/Encounter-v0", 64, seed=0)
    environment.reset()
    seen = {True: 0, False: 0}
    for _ in range(220):
        _, _, dones, infos = environment.step(np.zeros((64, 2), np.float32))
        for row in np.flatnonzero(dones):
            assert infos[row]["TimeLimit.truncated"] is not infos[row]["collision"]
            assert infos[row]["is_success"] is not infos[row]["collision"]
            seen[infos[row]["collision"]] += 1
        assert all(info == {} for info, done in zip(infos, dones, strict=True) if not done)
    assert min(seen.values()) > 5


def test_terminal_observation_is_of_the_old_episode():
    environment = make_vec_env("rss_gym/Encounter-v0", N, seed=3, **FAST)
    environment.reset()
    offset = [field.name for field in fields(environment.params)].index("way_point_right_m")
    for _ in range(200):
        observation, _, dones, infos = environment.step(np.full((N, 2), [0.0, 0.1], np.float32))
        for row in np.flatnonzero(dones):
            assert infos[row]["terminal_observation"][offset] > observation[row][offset] == 0.0
            return
    raise AssertionError("no episode ended")


def test_infos_are_dictionaries_of_their_own():
    environment = make_vec_env("rss_gym/Encounter-v0", N, seed=0)
    environment.reset()
    infos = environment.step(np.zeros((N, 2), np.float32))[3]
    assert len({id(info) for info in infos}) == N


def test_wrappers_and_learner(tmp_path):
    venv = VecMonitor(
        make_vec_env("rss_gym/Encounter-v0", N, seed=0, **FAST), info_keywords=("collision", "is_success")
    )
    venv = VecNormalize(VecFrameStack(venv, 2))
    model = PPO("MlpPolicy", venv, n_steps=64, batch_size=96, n_epochs=1, seed=0)
    model.learn(N * 64 * 3)
    assert len(model.ep_info_buffer) > 0
    assert {"r", "l", "collision"} <= set(model.ep_info_buffer[0])
    mean, std = evaluate_policy(model, venv, n_eval_episodes=4)
    assert np.isfinite([mean, std]).all()


def test_video(tmp_path):
    pytest.importorskip("moviepy")
    venv = make_vec_env("rss_gym/Encounter-v0", 2, seed=0, render_mode="rgb_array")
    venv = VecVideoRecorder(venv, str(tmp_path), record_video_trigger=lambda step: step == 0, video_length=4)
    venv.reset()
    for _ in range(6):
        venv.step(np.zeros((2, 2), np.float32))
    venv.close()
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]


def test_seeds_and_options_apply_at_the_next_reset_only():
    environment = make_vec_env("rss_gym/Encounter-v0", 3, seed=5)
    first = environment.reset()
    second = environment.reset()
    assert not np.array_equal(first, second)
    assert environment.seed(5) == [5, 6, 7]
    np.testing.assert_array_equal(environment.reset(), first)
    environment.seed(5)
    environment.set_options({"split": "validation", "episode": 4})
    np.testing.assert_array_equal(environment.reset()[1], single(6, {"split": "validation", "episode": 4}))
    environment.seed(5)
    environment.set_options([{}, {"episode": 9}, {}])
    seen = environment.reset()
    np.testing.assert_array_equal(seen[0], first[0])
    np.testing.assert_array_equal(seen[1], single(6, {"episode": 9}))


def single(seed, options):
    return gym.make("rss_gym/Encounter-v0").reset(seed=seed, options=options)[0]


def test_attributes_and_methods():
    environment = make_vec_env("rss_gym/Encounter-v0", 3, seed=0, channel="quadcopter")
    environment.reset()
    assert environment.get_attr("params", 1)[0].channels[0].path_loss_factor == 3.3
    environment.set_attr("tag", "b", [1])
    assert environment.get_attr("tag", [1]) == ["b"] and not environment.has_attr("tag")
    assert environment.env_is_wrapped(gym.Wrapper, [0, 2]) == [False, False]
    infos = environment.env_method("info", indices=[0, 2])
    assert len(infos) == 2 and infos[0]["collision"] is False
    with pytest.raises(ParamsError, match="params"):
        environment.set_attr("params", None)
    with pytest.raises(AttributeError):
        environment.get_attr("nothing")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"env_id": "rss_gym/Encounter-v9"}, "did you mean"),
        ({"env_id": "rss_gym/Encounter-v0", "n_envs": 0}, "n_envs"),
        ({"env_id": "rss_gym/Encounter-v0", "chanel": "paper"}, "chanel"),
        ({"env_id": "rss_gym/Encounter-v0", "seed": -1}, "seed"),
        ({"env_id": "rss_gym/Encounter-v0", "render_mode": "human"}, "render_mode"),
    ],
)
def test_bad_input_is_one_sentence(arguments, words):
    with pytest.raises(ParamsError, match=words) as caught:
        make_vec_env(**arguments)
    assert "\n" not in str(caught.value)


def test_bad_actions_and_order():
    environment = make_vec_env("rss_gym/Encounter-v0", 3, seed=0)
    with pytest.raises(gym.error.ResetNeeded):
        environment.step(np.zeros((3, 2), np.float32))
    environment.reset()
    with pytest.raises(ValueError, match="not finite"):
        environment.step(np.full((3, 2), np.nan, np.float32))
    with pytest.raises(gym.error.ResetNeeded, match="step_async"):
        environment.step_wait()


# -- as SB3's own function --------------------------------------------------------------------------------------------


def trained(venv):
    return PPO("MlpPolicy", venv, n_steps=64, batch_size=64, n_epochs=1, seed=0, device="cpu").learn(1500)


def test_it_is_monitored_by_default(tmp_path):
    from stable_baselines3.common.monitor import load_results

    model = trained(make_vec_env("rss_gym/Encounter-v0", 8, seed=0, monitor_dir=str(tmp_path / "log"), **FAST))
    assert len(model.ep_info_buffer) > 0 and {"r", "l", "t"} <= set(model.ep_info_buffer[0])
    model.get_env().close()
    pytest.importorskip("pandas")
    assert len(load_results(str(tmp_path / "log"))) >= len(model.ep_info_buffer)


@pytest.mark.parametrize("name", ["rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0"])
@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"n_envs": 3},
        {"env_kwargs": {"channel": "outdoor", "intruders": 2}},
        {"env_kwargs": {"max_episode_steps": 5}},
        {"seed": 3, "start_index": 7},
        {"monitor_kwargs": {"info_keywords": ("collision",)}},
        {"monitor_kwargs": {"allow_early_resets": False}},
        {"wrapper_class": gym.wrappers.ClipAction},
        {"wrapper_class": gym.wrappers.TimeAwareObservation, "wrapper_kwargs": {"normalize_time": False}},
    ],
    ids=str,
)
def test_it_does_what_sb3_s_function_does(name, arguments):
    from stable_baselines3.common.env_util import make_vec_env as theirs

    seeded = {"seed": 5} | arguments
    one, two = make_vec_env(name, **seeded), theirs(name, **seeded)
    assert one.num_envs == two.num_envs
    assert one.observation_space == two.observation_space and one.action_space == two.action_space
    np.testing.assert_array_equal(one.reset(), two.reset())
    for _ in range(12):
        action = np.zeros((one.num_envs, *one.action_space.shape), np.float32)
        ours, expected = one.step(action), two.step(action)
        for got, wanted in zip(ours[:3], expected[:3], strict=True):
            np.testing.assert_allclose(got, wanted, rtol=1e-6)
        for row in np.flatnonzero(ours[2]):
            for key in ("r", "l"):
                assert ours[3][row]["episode"][key] == pytest.approx(
                    expected[3][row]["episode"][key], rel=1e-5, abs=1e-5
                )
            assert set(ours[3][row]["episode"]) == set(expected[3][row]["episode"])
            assert ours[3][row]["TimeLimit.truncated"] == expected[3][row]["TimeLimit.truncated"]


def test_ids_specs_and_callables():
    spec = gym.make("rss_gym/Encounter-v0", channel="outdoor", max_episode_steps=9).spec
    for given in ("rss_gym:rss_gym/Encounter-v0", spec, gym.spec("rss_gym/Encounter3D-v0")):
        venv = make_vec_env(given, 2, seed=0)
        venv.reset()
        assert venv.unwrapped.batch.n == 2
    assert make_vec_env(spec, 2).get_attr("params")[0].channels == Params.of(channel="outdoor").channels
    assert make_vec_env(lambda: gym.make("rss_gym/Encounter-v0"), 2).reset().shape[0] == 2
    wrapped = gym.wrappers.ClipAction(gym.make("rss_gym/Encounter-v0")).spec
    assert make_vec_env(wrapped, 2).env_is_wrapped(gym.wrappers.ClipAction) == [True, True]


@pytest.mark.parametrize("name", sorted(ROADS))
def test_roads(name):
    pytest.importorskip("highway_env")
    venv = make_vec_env(name, 2, seed=0)
    venv.reset()
    while not venv.step(np.ones(2, int))[2].any():
        pass
    assert venv.num_envs == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"vec_env_kwargs": {"start_method": "fork"}}, "start_method"),
        ({"vec_env_kwargs": {"every_info": True}, "every_info": True}, "twice"),
        ({"env_kwargs": {"channel": "paper"}, "channel": "outdoor"}, "twice"),
        ({"wrapper_class": gym.wrappers.ClipAction, "every_info": True}, "every_info"),
        ({"env_kwargs": {"chanel": "paper"}}, "chanel"),
        ({"env_id": "no_such_module:rss_gym/Encounter-v0"}, "no_such_module"),
        ({"env_id": 3}, "unknown"),
        ({"env_id": "CartPole-v1"}, "CartPole-v1"),
        ({"max_episode_steps": 0}, "max_episode_steps"),
    ],
)
def test_arguments_that_cannot_be_are_named(arguments, words):
    with pytest.raises(ParamsError, match=words):
        make_vec_env(**{"env_id": "rss_gym/Encounter-v0", "n_envs": 2} | arguments)
