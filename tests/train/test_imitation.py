"""The warm start: the rows fly the rule, the actor learns its actions, and stays until the critic can judge it."""

import csv

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 (extra `train`) is not installed")

import torch

from rss_gym.core import Batch
from rss_gym.train import imitation, recipe, run
from rss_gym.train.learner import Learner


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """As in a training."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def changes(small):
    """A warm start in seconds."""
    return {
        **small,
        "imitation.policy": "mpc",
        "imitation.episodes": 64,
        "imitation.epochs": 6,
        "imitation.batch_size": 256,
    }


def learner(changes, **more):
    return Learner.new(recipe.load("ppo", {**changes, **more}), 0)


def test_the_rows_fly_the_rule(changes):
    """Without a disturbance: the observations are those of the rule's own flights, and the actions its own."""
    one = learner(changes, **{"imitation.disturbance": 0.0})
    inputs, actions, episodes = imitation._flown(one)
    assert inputs.dtype == actions.dtype == np.float32 and len(inputs) == len(actions) and episodes >= 64
    teacher, batch, rows = one.recipe.teacher, Batch(one.recipe.params, 64), np.ones(64, bool)
    width = batch.observations.shape[1]
    batch.seed(np.arange(64, dtype=np.uint64))
    batch.reset(rows)
    state, moved = None, False
    for step in range(60):
        wanted, state = teacher.predict(batch.observations, state)
        np.testing.assert_array_equal(inputs[64 * step : 64 * (step + 1), :width], batch.observations)
        np.testing.assert_array_equal(actions[64 * step : 64 * (step + 1)], wanted)
        moved = moved or bool(wanted.any())
        batch.step(np.concatenate([wanted, np.zeros((64, 1))], axis=1), rows)
        rows &= ~(batch.episode["terminated"] | batch.episode["truncated"])
        assert rows.all()
    assert moved


def test_the_disturbance_has_the_deviation_that_is_asked_for(changes):
    """Actions of a rule that does nothing are the disturbance itself, correlated from decision to decision."""
    one = learner(changes, **{"imitation.policy": "none", "imitation.disturbance": 0.1})
    given = []
    step = one.venv.step
    one.venv.step = lambda actions: given.append(actions) or step(actions)
    _, actions, _ = imitation._flown(one)
    assert not actions.any()
    late = np.array(given)[40:]  # it starts at zero
    assert np.std(late) == pytest.approx(0.1, rel=0.05)
    products = np.mean(late[1:] * late[:-1]) / np.mean(late**2)
    assert products == pytest.approx(imitation.CORRELATION, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    "more",
    [{}, {"vec.stack": 2, "vec.normalise_observation": True}, {"vec.normalise_reward": False}],
    ids=["plain", "wrapped", "bare"],
)
def test_the_actor_learns_the_rule(changes, more):
    one = learner(changes, **more)
    before = [parameter.clone() for parameter in one.model.policy.value_net.parameters()]
    text = imitation.imitate(one)
    error, spread = (float(word) for word in text.split() if word.startswith("0."))
    assert error < 0.95 * spread and "imitated mpc" in text
    # What the exported policy does is what was fitted, seen through all wrappers.
    inputs, actions, _ = imitation._flown(one)
    with torch.no_grad():
        policy = one.model.policy
        mean = policy.action_net(policy.mlp_extractor.policy_net(torch.as_tensor(inputs))).numpy()
    assert np.sqrt(np.mean((mean - actions) ** 2)) < 1.3 * error
    for parameter, kept in zip(one.model.policy.value_net.parameters(), before, strict=True):
        assert bool((parameter == kept).all())


@pytest.mark.slow
def test_the_same_seed_imitates_alike(changes):
    weights = []
    for _ in range(2):
        one = learner(changes)
        imitation.imitate(one)
        weights.append(one.model.policy.action_net.weight.detach().numpy().copy())
    np.testing.assert_array_equal(*weights)


def actor_of(one):
    policy = one.model.policy
    parts = (policy.mlp_extractor.policy_net, policy.action_net)
    return [policy.log_std, *(parameter for part in parts for parameter in part.parameters())]


def critic_of(one):
    policy = one.model.policy
    return [*policy.mlp_extractor.value_net.parameters(), *policy.value_net.parameters()]


def test_the_critic_learns_alone_first_and_a_run_begins_with_what_was_imitated(changes, tmp_path, capsys):
    changes = {**changes, "recipe.steps": 3072, "imitation.critic_steps": 2048, "algorithm.learning_rate": 1e-3}
    seen = {}
    save = Learner.save

    def kept(self, folder):
        copies = [[p.detach().clone() for p in part(self)] for part in (actor_of, critic_of)]
        seen.setdefault(self.model.num_timesteps, copies)
        save(self, folder)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Learner, "save", kept)
        run.start(recipe.load("ppo", changes), tmp_path / "run", show=False)
    out = capsys.readouterr().out
    assert "seed 0, 0 steps: imitated mpc" in out and "seed 0, 0 steps: cost" in out
    assert sorted(seen) == [0, 1024, 2048, 3072]

    def moved(one, other, part):
        return any(bool((a != b).any()) for a, b in zip(seen[one][part], seen[other][part], strict=True))

    assert [moved(*steps, 0) for steps in ((0, 1024), (1024, 2048), (2048, 3072))] == [False, False, True]
    assert [moved(*steps, 1) for steps in ((0, 1024), (1024, 2048), (2048, 3072))] == [True] * 3
    with open(tmp_path / "run" / "seed-0" / "validation.csv", newline="") as file:
        assert [int(row["steps"]) for row in csv.DictReader(file)] == [0, 2048, 3072]


@pytest.mark.slow
def test_a_run_that_goes_on_does_not_imitate_again(changes, tmp_path, capsys, monkeypatch):
    """Killed as soon as the imitation is saved."""
    changes = {**changes, "recipe.steps": 2048, "imitation.critic_steps": 1024}
    chosen = recipe.load("ppo", changes)

    class Killed(BaseException):
        pass

    def killed(*_, **__):
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr("rss_gym.train.loop.TrainingCallback._validate", killed)
        with pytest.raises(Killed):
            run.start(chosen, tmp_path / "run", show=False)
    monkeypatch.setattr("rss_gym.train.loop.imitate", killed)
    folder = tmp_path / "run" / "seed-0" / "checkpoint"
    saved = Learner.saved(chosen, 0, folder)
    assert saved.model.num_timesteps == 0
    run.resume(tmp_path / "run", show=False)
    assert "imitated" not in capsys.readouterr().out.replace("0 steps: imitated mpc", "", 1)
    with open(tmp_path / "run" / "seed-0" / "validation.csv", newline="") as file:
        assert [int(row["steps"]) for row in csv.DictReader(file)] == [2048]
