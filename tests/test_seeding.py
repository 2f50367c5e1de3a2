"""Which episode a reset starts: (split, seed, number), and nothing else has a say."""

import random

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from rss_gym.env import EncounterEnv
from rss_gym.vector import EncounterVectorEnv

LARGEST = 2**63 - 1


def key(env):
    return [int(value) for value in env.unwrapped.batch.episode["key"]]


def flight(env, steps=20, **keywords):
    """A reset and the first steps after it."""
    results = [env.reset(**keywords)]
    env.action_space.seed(0)
    for _ in range(steps):
        results.append(env.step(env.action_space.sample()))
    return results


@pytest.fixture(params=[False, True], ids=["single", "vector"])
def make(request):
    def maker(**keywords):
        return EncounterVectorEnv(3, **keywords) if request.param else EncounterEnv(**keywords)

    return maker


def test_same_seed_twice(make):
    env, other = make(), make()
    first = flight(env, seed=11)
    assert data_equivalence(first, flight(env, seed=11), exact=True)
    assert data_equivalence(first, flight(other, seed=11), exact=True)
    assert not data_equivalence(first, flight(other, seed=14), exact=True)


def test_later_resets_go_on(make):
    """A reset without a seed starts the next episode, with one the first again."""
    env, other = make(), make()
    env.reset(seed=3)
    keys = [key(env)]
    for _ in range(5):
        env.reset()
        keys.append(key(env))
    assert len({k for row in keys for k in row}) == len(keys) * len(keys[0])
    # Whether the episodes are flown, and how far, does not matter.
    for number, expected in enumerate(keys):
        flight(other, steps=7 * number, seed=3 if number == 0 else None)
        assert key(other) == expected
    env.reset(seed=3)
    assert key(env) == keys[0]


def test_replay(make):
    """`options` start any episode; those after it follow."""
    env, other = make(), make()
    env.reset(seed=3)
    episodes = [flight(env) for _ in range(4)]  # 1, 2, 3, 4
    other.reset(seed=3)
    assert data_equivalence(flight(other, options={"episode": 3}), episodes[2], exact=True)
    assert data_equivalence(flight(other), episodes[3], exact=True)
    assert data_equivalence(flight(make(), seed=3, options={"split": "train", "episode": 2}), episodes[1], exact=True)
    assert data_equivalence(flight(other, options={"episode": np.int64(1)}), episodes[0], exact=True)


def test_splits_differ(make):
    keys = {}
    for split in ("train", "validation", "suite"):
        env = make()
        keys[split] = []
        for number in range(20):
            env.reset(seed=0, options={"split": split, "episode": number})
            keys[split] += key(env)
    distinct = set().union(*map(set, keys.values()))
    assert len(distinct) == sum(map(len, keys.values()))
    # They cannot meet for any seed: the top bits are the split's.
    assert {split: {k >> 62 for k in values} for split, values in keys.items()} == {
        "train": {0},
        "validation": {1},
        "suite": {2},
    }


@pytest.mark.parametrize("split", ["validation", "suite"])
@pytest.mark.parametrize("options", [{}, {"episode": 5}])
def test_a_split_holds_for_one_episode(make, split, options):
    """No later reset, an automatic one neither, strays into the episodes of the tests."""
    env, other = make(), make()
    env.reset(seed=0, options={"split": split, **options})
    assert (env.batch.episode["split"] == {"validation": 1, "suite": 2}[split]).all()
    number = int(env.batch.episode["number"][0])
    env.reset()
    other.reset(seed=0, options={"split": "train", "episode": number + 1})
    assert key(env) == key(other)


def test_options_are_not_kept_or_changed(make):
    options = {"split": "suite", "episode": 4}
    env = make()
    env.reset(seed=1, options=options)
    env.reset()
    assert options == {"split": "suite", "episode": 4}
    env.reset(options={})
    assert (env.batch.episode["number"] == 6).all() and (env.batch.episode["split"] == 0).all()


def test_first_reset_without_a_seed_differs():
    """Two unseeded environments do not fly the same encounters; one that was pinned by Gymnasium's generator does."""
    keys = set()
    for _ in range(5):
        single, vector = EncounterEnv(), EncounterVectorEnv(3)
        single.reset()
        vector.reset()
        keys |= {*key(single), *key(vector)}
    assert len(keys) == 20


def test_seed_is_gymnasiums_too(make):
    env = make()
    env.reset(seed=9)
    state = env.np_random.bit_generator.state
    flight(env)
    assert env.np_random.bit_generator.state == state
    assert env.np_random.bit_generator.state == np.random.Generator(np.random.PCG64(9)).bit_generator.state


@pytest.mark.filterwarnings("error")
def test_global_generators_are_left_alone(make):
    env = make()
    np.random.seed(0)  # noqa: NPY002 (the global state is what is tested)
    random.seed(0)
    first = flight(env, seed=2)
    states = np.random.get_state()[1].tobytes(), random.getstate()  # noqa: NPY002
    np.random.seed(99)  # noqa: NPY002
    random.seed(99)
    assert data_equivalence(first, flight(env, seed=2), exact=True)
    env.reset()
    np.random.seed(0)  # noqa: NPY002
    random.seed(0)
    flight(env, seed=2)
    assert (np.random.get_state()[1].tobytes(), random.getstate()) == states  # noqa: NPY002


@pytest.mark.parametrize("seed", [0, 1, 2**20, 2**32, 2**40 + 1, LARGEST - 3])
def test_large_seeds(seed):
    """All 63 bits count, as Python and as NumPy numbers."""
    env, envs = EncounterEnv(), EncounterVectorEnv(3)
    keys = []
    for row in range(3):
        env.reset(seed=seed + row)
        keys += key(env)
    envs.reset(seed=seed)
    assert key(envs) == keys
    envs.reset(seed=np.int64(seed))
    assert key(envs) == keys
    envs.reset(seed=np.arange(seed, seed + 3))
    assert key(envs) == keys
    env.reset(seed=seed ^ 2**62 if seed else 2**62)
    assert key(env)[0] not in keys


def test_seeds_of_a_batch_end_with_the_range():
    env = EncounterVectorEnv(2)
    EncounterEnv().reset(seed=LARGEST)
    with pytest.raises(ValueError, match="seed"):
        env.reset(seed=LARGEST)


# -- rows -------------------------------------------------------------------------------------------------------------


def test_list_of_seeds():
    envs, env = EncounterVectorEnv(3), EncounterEnv()
    observations, _ = envs.reset(seed=[5, 900, 5])
    for row, seed in enumerate([5, 900, 5]):
        np.testing.assert_array_equal(observations[row], env.reset(seed=seed)[0])
    # None goes on with the row's own episodes.
    envs.reset(seed=[5, None, 6])
    assert envs.batch.episode["number"].tolist() == [0, 1, 0]
    assert envs.batch.episode["seed"].tolist() == [5, 900, 6]
    envs.reset(seed=[None, None, None])
    assert envs.batch.episode["number"].tolist() == [1, 2, 1]


def test_list_of_seeds_on_the_first_reset():
    envs = EncounterVectorEnv(4)
    envs.reset(seed=[7, None, 8, None])
    seeds = envs.batch.episode["seed"].tolist()
    assert (seeds[0], seeds[2]) == (7, 8)
    assert len(set(seeds)) == 4


def test_episode_per_row():
    envs, env = EncounterVectorEnv(3), EncounterEnv()
    for given in ([4, 0, 2], np.array([4, 0, 2]), (4, 0, 2)):
        observations, _ = envs.reset(seed=20, options={"split": "suite", "episode": given})
        for row, number in enumerate([4, 0, 2]):
            expected, _ = env.reset(seed=20 + row, options={"split": "suite", "episode": number})
            np.testing.assert_array_equal(observations[row], expected)
    envs.reset()
    assert envs.batch.episode["number"].tolist() == [5, 1, 3]


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_mask_touches_its_rows_only(mode):
    """With and without seeds and options, in every mode."""
    envs = EncounterVectorEnv(4, autoreset_mode=mode)
    envs.reset(seed=50)
    for _ in range(5):
        envs.step(envs.action_space.sample())
    mask = np.array([False, True, False, True])
    for options, seed, expected in [
        ({}, None, [(50, 0), (51, 1), (52, 0), (53, 1)]),
        ({}, 70, [(50, 0), (71, 0), (52, 0), (73, 0)]),
        ({"episode": [9, 9, 9, 8]}, None, [(50, 0), (71, 9), (52, 0), (73, 8)]),
        ({"split": "suite"}, [1, 2, 3, 4], [(50, 0), (2, 0), (52, 0), (4, 0)]),
        ({}, [1, None, 3, 5], [(50, 0), (2, 1), (52, 0), (5, 0)]),
    ]:
        before = envs.batch.state.aircraft[~mask].tobytes(), envs.batch.state.links[~mask].tobytes()
        observations = envs.batch.observations[~mask].copy()
        result, infos = envs.reset(seed=seed, options={**options, "reset_mask": mask})
        episode = envs.batch.episode
        assert list(zip(episode["seed"].tolist(), episode["number"].tolist(), strict=True)) == expected
        assert (envs.batch.state.aircraft[~mask].tobytes(), envs.batch.state.links[~mask].tobytes()) == before
        np.testing.assert_array_equal(result[~mask], observations)
        assert (infos["_min_separation_m"] == mask).all()
        assert (infos["min_separation_m"][mask] > 0).all()
        envs.step(envs.action_space.sample())
    # Rows 1 and 3 were on split `suite` for one episode.
    assert envs.batch.episode["split"].tolist() == [0, 0, 0, 0]


def test_masked_reset_of_a_row_that_has_ended():
    """In NextStep a row may be reset by hand instead of by the step after its end."""
    envs = EncounterVectorEnv(2, tail_min_s=0.0, tail_max_s=0.0)
    envs.reset(seed=0)
    ended = np.zeros(2, bool)
    while not ended.any() or ended.all():
        _, _, terminated, truncated, _ = envs.step(np.zeros((2, 2)))
        ended = terminated | truncated
    envs.reset(options={"reset_mask": ended})
    numbers = envs.batch.episode["number"].copy()
    _, rewards, terminated, truncated, _ = envs.step(np.ones((2, 2)))
    np.testing.assert_array_equal(envs.batch.episode["number"], numbers)
    assert (rewards != 0).all()
    assert (envs.batch.episode["tick"][ended] == envs.params.clock.ticks_per_decision).all()


def test_noise_belongs_to_the_episode_not_to_the_order():
    """Episode 7 is the same after six others, at once, and in any row."""
    env, envs = EncounterEnv(), EncounterVectorEnv(4)
    env.reset(seed=31)
    for _ in range(6):
        env.reset()
    late = flight(env)
    assert data_equivalence(late, flight(EncounterEnv(), seed=31, options={"episode": 7}), exact=True)
    envs.reset(seed=[1, 31, 2, 31], options={"episode": [3, 7, 7, 7]})
    env.action_space.seed(0)
    for result in late[1:]:
        action = env.action_space.sample()
        observations, rewards, *_ = envs.step(np.broadcast_to(action, (4, 2)))
        for row in (1, 3):
            np.testing.assert_array_equal(observations[row], result[0])
            assert rewards[row] == result[1]
