"""The behaviour that Gymnasium's own tests ask of its vector environments, asked of ours.

Single environments stepped one by one are the reference, so that it runs on every version of Gymnasium from 0.29.1.
"""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector.utils import batch_space

from rss_gym.rows import AutoresetMode
from rss_gym.vector import EncounterVectorEnv

ID = "rss_gym/Encounter-v0"
MODES = ("NextStep", "SameStep", "Disabled")
STATISTICS = getattr(gym.wrappers, "vector", gym.wrappers).RecordEpisodeStatistics
# The one mode that the wrapper of an older Gymnasium knows.
COUNTED = (
    MODES if hasattr(gym.vector, "AutoresetMode") else (("SameStep", "NextStep")[hasattr(gym.wrappers, "vector")],)
)
needs_vector_wrappers = pytest.mark.skipif(not hasattr(gym.wrappers, "vector"), reason="Gymnasium before 1.0")
every_mode = pytest.mark.parametrize("mode", MODES)


@pytest.fixture
def made():
    """A function that makes vector environments, which are closed at the end."""
    envs = []

    def make(rows=3, **keywords):
        envs.append(EncounterVectorEnv(rows, **keywords))
        envs[-1].action_space.seed(7)
        return envs[-1]

    yield make
    for one in envs:
        one.close()


def singles(rows, **keywords):
    return [gym.make(ID, **keywords) for _ in range(rows)]


# -- shapes, spaces, types --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 2, 9])
@pytest.mark.parametrize("action", ["velocity", "discrete"])
def test_spaces_are_batches_of_those_of_one(made, rows, action):
    envs, one = made(rows, action=action), gym.make(ID, action=action)
    assert envs.num_envs == rows
    assert envs.single_observation_space == one.observation_space and envs.single_action_space == one.action_space
    assert envs.observation_space == batch_space(one.observation_space, rows)
    assert envs.action_space == batch_space(one.action_space, rows)
    observations, infos = envs.reset(seed=0)
    assert isinstance(observations, np.ndarray) and observations.dtype == envs.observation_space.dtype
    assert observations.shape == (rows, *envs.single_observation_space.shape) and observations in envs.observation_space
    for sampled in (envs.action_space.sample(), [one.action_space.sample() for _ in range(rows)]):
        observations, rewards, terminations, truncations, infos = envs.step(sampled)
        assert observations.dtype == np.float32 and observations in envs.observation_space
        assert rewards.shape == (rows,) and rewards.dtype == np.float64
        for flags in (terminations, truncations):
            assert flags.shape == (rows,) and flags.dtype == np.bool_
        for name, values in infos.items():
            assert values.shape[0] == rows and f"_{name.removeprefix('_')}" in infos


def test_what_is_returned_stays_as_it_is(made):
    envs = made()
    returned = [envs.reset(seed=1)]
    returned += [envs.step(envs.action_space.sample()) for _ in range(3)]
    kept = [[np.copy(value) for value in step[:-1]] for step in returned]
    for _ in range(5):
        envs.step(envs.action_space.sample())
    for step, copies in zip(returned, kept, strict=True):
        for value, copy in zip(step, copies, strict=False):
            np.testing.assert_array_equal(value, copy)


@pytest.mark.parametrize("action", ["velocity", "discrete"])
def test_too_few_and_too_many_actions_are_refused_and_nothing_moves(made, action):
    envs = made(4, action=action)
    envs.reset(seed=0)
    right = envs.action_space.sample()
    first = made(4, action=action)
    first.reset(seed=0)
    for wrong in (right[:3], np.concatenate([right, right[:1]])):
        with pytest.raises(ValueError, match="4"):
            envs.step(wrong)
    with pytest.raises((TypeError, ValueError)):
        envs.step(0)
    assert data_equivalence(envs.step(right), first.step(right))


# -- automatic resets -------------------------------------------------------------------------------------------------


class Reference:
    """Single environments in a list, reset by hand as Gymnasium describes each mode."""

    def __init__(self, mode, rows, **keywords):
        self.mode, self.envs = mode, singles(rows, **keywords)
        self.ended = np.zeros(rows, bool)

    def reset(self, seed):
        return np.stack([env.reset(seed=seed + row)[0] for row, env in enumerate(self.envs)])

    def step(self, actions):
        rows = []
        for row, (env, action) in enumerate(zip(self.envs, actions, strict=True)):
            if self.ended[row]:
                rows.append((env.reset()[0], 0.0, False, False, None))
                continue
            observation, reward, terminated, truncated, _ = env.step(action)
            final = observation if terminated or truncated else None
            if final is not None and self.mode == "SameStep":
                observation, _ = env.reset()
            rows.append((observation, reward, terminated, truncated, final))
        observations, rewards, terminations, truncations, finals = zip(*rows, strict=True)
        terminations, truncations = np.array(terminations), np.array(truncations)
        self.ended = (terminations | truncations) & (self.mode == "NextStep")
        return np.stack(observations), np.array(rewards), terminations, truncations, finals


@every_mode
@pytest.mark.parametrize("limit", [1, 2, 5, None])
def test_rows_are_single_environments_through_their_resets(made, mode, limit):
    keywords = {} if limit is None else {"max_episode_steps": limit}
    envs, reference = made(autoreset_mode=mode, **keywords), Reference(mode, 3, **keywords)
    assert envs.metadata["autoreset_mode"] is AutoresetMode(mode)
    np.testing.assert_array_equal(envs.reset(seed=20)[0], reference.reset(20))
    ends = 0
    while ends < 7:
        actions = envs.action_space.sample()
        *result, infos = envs.step(actions)
        *expected, finals = reference.step(actions)
        for one, two in zip(result, expected, strict=True):
            np.testing.assert_array_equal(one, two)
        ended = result[2] | result[3]
        ends += ended.sum()
        if mode == "SameStep" and ended.any():
            np.testing.assert_array_equal(infos["_final_obs"], ended)
            np.testing.assert_array_equal(infos["_final_info"], ended)
            for row, final in enumerate(finals):
                np.testing.assert_array_equal(infos["final_obs"][row], final)
        else:
            assert "final_obs" not in infos
        if mode == "Disabled" and ended.any():
            observations, _ = envs.reset(options={"reset_mask": ended})
            for row in np.flatnonzero(ended):
                np.testing.assert_array_equal(observations[row], reference.envs[row].reset()[0])


def test_metadata_is_of_one_environment(made):
    first, second = made(autoreset_mode="SameStep"), made(autoreset_mode=AutoresetMode.DISABLED)
    assert first.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert second.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    assert "autoreset_mode" not in EncounterVectorEnv.metadata and "autoreset_mode" not in gym.make(ID).metadata


# -- resets of some rows ----------------------------------------------------------------------------------------------


@every_mode
def test_a_mask_resets_its_rows_only(made, mode):
    envs = made(autoreset_mode=mode)
    first, _ = envs.reset(seed=[0, 1, 2])
    for _ in range(3):
        last, *_ = envs.step(envs.action_space.sample())
    mask = np.array([True, True, False])
    observations, infos = envs.reset(seed=[0, 1, 0], options={"reset_mask": mask})
    np.testing.assert_array_equal(observations[:2], first[:2])
    np.testing.assert_array_equal(observations[2], last[2])
    np.testing.assert_array_equal(infos["_cost_m"], mask)


@pytest.mark.parametrize(
    ("mask", "kind", "said"),
    [
        (np.array([True]), ValueError, r"shape `\(3,\)`, got \(1,\)"),
        (np.array([True, True, False, False]), ValueError, r"shape `\(3,\)`, got \(4,\)"),
        (np.array([[True, True, True]]), ValueError, r"shape `\(3,\)`, got \(1, 3\)"),
        (np.array([False] * 3), ValueError, "at least one True"),
        (np.array([1, 1, 0]), TypeError, "got int64"),
        (np.array([1.0, 1.0, 0.0]), TypeError, "got float64"),
        ([True, True, False], TypeError, "got <class 'list'>"),
        ("all", TypeError, "got <class 'str'>"),
        (None, TypeError, "got <class 'NoneType'>"),
    ],
)
def test_a_wrong_mask_is_refused_in_gymnasium_s_words(made, mask, kind, said):
    envs = made()
    last, _ = envs.reset(seed=0)
    with pytest.raises(kind, match=rf"`options\['reset_mask'\]` must .*{said}"):
        envs.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(envs.batch.observations, last)


# -- seeds ------------------------------------------------------------------------------------------------------------


def test_seeds_are_those_of_single_environments(made):
    envs = made()
    whole, _ = envs.reset(seed=42)
    listed, _ = made().reset(seed=[42, 43, 44])
    np.testing.assert_array_equal(whole, listed)
    ones = singles(3)
    np.testing.assert_array_equal(whole, np.stack([env.reset(seed=42 + row)[0] for row, env in enumerate(ones)]))
    for _ in range(3):  # without a seed every row goes on with its own episodes
        np.testing.assert_array_equal(envs.reset()[0], np.stack([env.reset()[0] for env in ones]))


def test_two_of_the_same_seed_are_equal_and_others_are_not(made):
    first, second, third = made(), made(), made()
    third.reset(seed=1)
    assert data_equivalence(first.reset(seed=0), second.reset(seed=0))
    for _ in range(150):
        actions = first.action_space.sample()
        np.testing.assert_array_equal(actions, second.action_space.sample())
        assert data_equivalence(result := first.step(actions), second.step(actions))
        assert not np.array_equal(result[0], third.step(actions)[0])


def test_rows_without_a_seed_fly_different_encounters(made):
    envs = made(5)
    observations, _ = envs.reset()
    assert len(np.unique(observations, axis=0)) == 5 and not np.array_equal(observations, made(5).reset()[0])


# -- attributes, frames, closing --------------------------------------------------------------------------------------


def test_call_reads_and_calls(made):
    envs = made(render_mode="rgb_array_list")
    envs.reset(seed=0)
    images = envs.call("render")
    assert isinstance(images, tuple) and [len(frames) for frames in images] == [1, 1, 1]
    assert envs.call("params") == envs.get_attr("params") == (envs.params,) * 3
    envs.set_attr("gain", [9.81, 3.72, 8.87])
    assert envs.get_attr("gain") == (9.81, 3.72, 8.87)


def test_frames_are_a_tuple_of_one_a_row(made):
    envs = made(render_mode="rgb_array")
    envs.reset(seed=0)
    frames = envs.render()
    assert isinstance(frames, tuple) and len(frames) == 3 and envs.render_mode == "rgb_array"
    for row, (frame, one) in enumerate(zip(frames, singles(3, render_mode="rgb_array"), strict=True)):
        one.reset(seed=row)
        np.testing.assert_array_equal(frame, one.render())
    assert made().render_mode is None and made().render() is None


def test_closing_twice_is_no_error(made):
    envs = made(render_mode="rgb_array")
    envs.reset(seed=0)
    envs.render()
    assert not envs.closed
    envs.close()
    envs.close()
    assert envs.closed
    made().close()  # before any reset


# -- wrappers ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", COUNTED)
@pytest.mark.parametrize("limit", [3, None])
def test_statistics_of_episodes(made, mode, limit):
    """Return and length of every episode are the sums over its steps."""
    envs = STATISTICS(made(autoreset_mode=mode, **({} if limit is None else {"max_episode_steps": limit})))
    envs.reset(seed=3)
    returns, lengths, fresh, ends = np.zeros(3), np.zeros(3, int), np.zeros(3, bool), 0
    while ends < 5:
        _, rewards, terminations, truncations, infos = envs.step(envs.action_space.sample())
        returns, lengths = np.where(fresh, 0.0, returns + rewards), np.where(fresh, 0, lengths + 1)
        ended = terminations | truncations
        if ended.any():
            said = infos["episode"]
            np.testing.assert_allclose(np.asarray(said["r"])[ended], returns[ended], rtol=1e-6)
            np.testing.assert_array_equal(np.asarray(said["l"])[ended], lengths[ended])
            ends += ended.sum()
        fresh = ended & (mode == "NextStep")
        again = ended & (mode != "NextStep")
        returns[again], lengths[again] = 0.0, 0
        if mode == "Disabled" and ended.any():
            envs.reset(options={"reset_mask": ended})


WRAPPERS = [
    ("FlattenObservation", {}),
    ("ClipAction", {}),
    ("RescaleAction", {"min_action": np.float32(-2.0), "max_action": np.float32(2.0)}),
    ("ClipReward", {"min_reward": -0.25, "max_reward": 0.75}),
]


@needs_vector_wrappers
@pytest.mark.parametrize(("name", "keywords"), WRAPPERS, ids=lambda value: value if isinstance(value, str) else "")
def test_a_wrapper_round_the_batch_is_the_wrapper_round_each(made, name, keywords):
    ours = getattr(gym.wrappers.vector, name)(made(), **keywords)
    single = getattr(gym.wrappers, name)
    theirs = gym.make_vec(ID, num_envs=3, vectorization_mode="sync", wrappers=(lambda env: single(env, **keywords),))
    assert ours.observation_space == theirs.observation_space and ours.action_space == theirs.action_space
    assert data_equivalence(ours.reset(seed=123), theirs.reset(seed=123))
    for _ in range(120):
        actions = ours.action_space.sample()
        for one, two in zip(ours.step(actions), theirs.step(actions), strict=True):
            assert data_equivalence(one, two)
    theirs.close()


@needs_vector_wrappers
def test_infos_as_a_list(made):
    envs = gym.wrappers.vector.DictInfoToList(made())
    _, infos = envs.reset(seed=0)
    for row, (info, one) in enumerate(zip(infos, singles(3), strict=True)):
        _, expected = one.reset(seed=row)
        assert info.keys() == expected.keys() and all(info[name] == expected[name] for name in info)


@needs_vector_wrappers
def test_running_means_are_those_of_the_observations(made):
    envs, plain = gym.wrappers.vector.NormalizeObservation(made(8)), made(8)
    envs.reset(seed=0)
    seen = [plain.reset(seed=0)[0]]
    for _ in range(60):
        actions = plain.action_space.sample()
        normal, *_ = envs.step(actions)
        seen.append(plain.step(actions)[0])
    np.testing.assert_allclose(envs.obs_rms.mean, np.concatenate(seen).mean(axis=0), atol=1e-3)
    assert normal.dtype == np.float32 and np.isfinite(normal).all()
