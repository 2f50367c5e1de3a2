"""The gradient through the flight: the surrogate repeats the world, and its gradient is that of what it computes."""

import numpy as np
import pytest
import torch

from rss_gym.baselines.features import FEATURES, append
from rss_gym.baselines.features.masks import kept
from rss_gym.core import decode
from rss_gym.params import ParamsError
from rss_gym.train import recipe
from rss_gym.train.learner import Learner
from rss_gym.train.pathwise.flights import Flights, record
from rss_gym.train.pathwise.surrogate import Surrogate, _tame

ROWS, WINDOW = 48, 90
RECIPES = {"plane": {}, "space": {}, "range": {}, "plane without ranges": {"policy.zeroed": "range"}}


def learner(name, **changes):
    small = {"vec.n_envs": ROWS, "imitation.episodes": 0, "policy.net_arch": [16], "algorithm.batch_size": 24}
    return Learner.new(recipe.load(f"pathwise-{name.split()[0]}", {**small, **RECIPES[name], **changes}), 0)


def flown(one, window=WINDOW):
    one.venv.reset()
    return record(one.course.venv.batch, one.agent(), window)


@pytest.fixture(scope="module", params=sorted(RECIPES))
def case(request):
    """A learner whose actor has only just been made, and its flights."""
    torch.manual_seed(0)
    one = learner(request.param)
    one.venv.reset()
    flights, episodes = record(one.course.venv.batch, one.agent(), WINDOW)
    return one, flights, episodes


def actor(one):
    policy = one.model.policy
    return lambda rows: policy.action_net(policy.mlp_extractor.policy_net(rows))


def test_flights_are_those_of_the_batch(case):
    _, flights, episodes = case
    assert 0 < len(flights) <= ROWS and flights.kept.shape == (WINDOW + 1, len(flights))
    assert sum(episode["l"] for episode in episodes) >= flights.kept.sum() > 0.5 * flights.kept.numel()
    assert not flights.seen["message_valid"][0].any() or (flights.seen["time_s"][0] == 0.0).any()
    assert flights.seen["message_valid"][2].all()  # it is held from then on
    assert (flights.decisions >= flights.kept.sum(dim=0) - 1).all()


def test_the_surrogate_sees_what_the_policy_saw(case):
    """At the recorded states the network's inputs are those computed from the observations."""
    one, _, _ = case
    batch, agent, rows = one.course.venv.batch, one.agent(), np.ones(ROWS, bool)
    one.venv.reset()
    numbers = batch.numbers.copy()
    flights, _ = record(batch, agent, WINDOW)
    batch.numbers[:] = numbers
    batch.reset(rows)
    features, mask = FEATURES[agent.network.features](one.recipe.params), kept(agent.network.zeroed, one.recipe.params)
    memory, state, first, seen = np.zeros((ROWS, features.columns)), None, rows, []
    for _ in range(60):
        seen.append(append(features, batch.observations * mask, memory))
        actions, state = agent.predict(batch.observations, state, first)
        batch.step(decode(actions, one.recipe.params, ROWS), np.zeros(ROWS, bool))
        first = np.zeros(ROWS, bool)
    compared = 0
    for t in range(0, 20, 3):
        state = flights.position[t], flights.velocity[t], flights.way_point[t]
        inputs = one.model.surrogate.inputs(flights, t, *state).numpy()
        step = np.round(flights.seen["time_s"][t].numpy() / one.recipe.params.clock.decision_s).astype(int)
        for row in np.flatnonzero(step < len(seen)):  # a row for an encounter, as all of them have heard a message
            np.testing.assert_allclose(inputs[row], seen[step[row]][row], atol=2e-4)
            compared += 1
    assert len(flights) == ROWS and compared > 50


def test_the_surrogate_flies_as_the_world(case):
    """With the actor's own actions the paths differ only by what gusts change within a decision."""
    one, flights, _ = case
    with torch.no_grad():
        separation, deviation = one.model.surrogate.fly(flights, actor(one), 1.0, 1e9)
    kept = flights.kept > 0.5
    away = torch.where(kept, (flights.intruder - flights.position).norm(dim=-1), torch.inf).amin(dim=0)
    off = ((flights.position - flights.planned).norm(dim=-1) * kept)[1:].sum(dim=0) / flights.decisions
    assert (separation - away).median().abs() < 0.3  # twice a decision against thrice
    assert ((separation - away).abs() < 3.0).float().mean() > 0.8
    assert deviation.mean() == pytest.approx(float(off.mean()), rel=0.03, abs=0.1)  # gusts change within a decision


def test_the_gradient_is_that_of_the_cost():
    """Against central differences, in double precision, without decay or cut."""
    torch.manual_seed(0)
    one = learner("plane")
    flights, _ = flown(one, window=25)
    double = Flights(
        seen={name: value.double() for name, value in flights.seen.items()},
        **{name: getattr(flights, name).double() for name in Flights.__dataclass_fields__ if name != "seen"},
    )
    surrogate: Surrogate = one.model.surrogate
    for name in ("_scale", "_low", "_high", "_kept"):
        setattr(surrogate, name, getattr(surrogate, name).double())
    policy = one.model.policy.double()
    shift = torch.zeros(2, dtype=torch.float64, requires_grad=True)

    def cost(offset):
        rows = actor(one)
        separation, deviation = surrogate.fly(double, lambda seen: rows(seen) + offset, 1.0, 1e9)
        return (deviation + torch.exp(-0.5 * (separation / 60.0) ** 2) * 20.0).mean()

    cost(shift).backward()
    with torch.no_grad():
        for axis in range(2):
            step = torch.zeros(2, dtype=torch.float64)
            step[axis] = 1e-5
            slope = float(cost(step) - cost(-step)) / 2e-5
            assert float(shift.grad[axis]) == pytest.approx(slope, rel=2e-3)
    assert all(torch.isfinite(value).all() for value in policy.parameters())


@pytest.mark.parametrize("name", ["plane", "space", "range"])
def test_a_gradient_is_finite_for_every_weight(name):
    one = learner(name)
    one.model.flights, _ = flown(one)
    cost, _, _ = one.model._cost(one.model.flights)
    cost.backward()
    policy = one.model.policy
    for value in [*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters()]:
        assert torch.isfinite(value.grad).all() and value.grad.abs().max() > 0.0


def test_a_batch_without_a_finite_gradient_is_left_out():
    """One in some hundred has a vector of no length; weights that are not finite would end the training."""
    one = learner("plane")
    one.model.flights, _ = flown(one)
    one.model.flights.gust[5, 0] = torch.nan
    one.model._setup_learn(100, None)
    one.model.train()
    assert one.model.skipped == one.model.n_epochs * 1
    assert all(torch.isfinite(value).all() for value in one.model.policy.parameters())


def test_encounters_that_have_ended_leave_the_gradient_finite():
    one = learner("plane")
    one.model.flights, _ = flown(one)
    one.model.flights.kept[1:, :3] = 0.0
    cost, _, _ = one.model._cost(one.model.flights)
    cost.backward()
    assert torch.isfinite(one.model.policy.action_net.weight.grad).all()


def test_the_cut_holds_each_encounter():
    given = torch.tensor([[3.0, 4.0, 0.0], [0.3, 0.4, 0.0], [0.0, 0.0, 0.0]])
    tamed = _tame(given, decay=0.5, largest=1.0)
    torch.testing.assert_close(tamed, torch.tensor([[0.6, 0.8, 0.0], [0.15, 0.2, 0.0], [0.0, 0.0, 0.0]]))


def test_training_lowers_the_cost():
    """On flights that it was not trained on."""
    torch.manual_seed(0)
    one = learner("plane", **{"recipe.steps": 60_000, "algorithm.learning_rate": 3e-3, "vec.n_envs": 96})
    others, _ = flown(one)
    with torch.no_grad():
        before = float(one.model._cost(others)[0])
    one.model.learn(one.recipe.steps)
    with torch.no_grad():
        after = float(one.model._cost(others)[0])
    assert after < 0.9 * before


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"world.intruders": 2}, "intruders must be 1"),
        ({"world.action": "displacement"}, "action must be 'velocity'"),
        ({"vec.stack": 2}, "stack must be 1"),
        ({"vec.normalise_observation": True}, "normalise_observation must be False"),
        ({"imitation.critic_steps": 10}, "critic_steps must be 0"),
        ({"curriculum": [{"start": 0.5, "gust_mps": 0.0}]}, "stages must be 0"),
        ({"algorithm.batch_size": 49}, "batch_size must be at most n_envs = 48"),
    ],
)
def test_what_cannot_be_differentiated_is_refused(changes, said):
    with pytest.raises(ParamsError, match="pathwise") as refused:
        learner("plane", **changes)
    assert said in str(refused.value)


def test_a_collision_is_seen_in_its_own_decision():
    """The surrogate repeats the least separation of flights that end in it."""
    one = learner("plane", **{"vec.n_envs": 200, "algorithm.batch_size": 100})
    policy = one.model.policy.action_net
    torch.nn.init.zeros_(policy.weight), torch.nn.init.zeros_(policy.bias)  # follows its path
    flights, episodes = flown(one, window=160)
    with torch.no_grad():
        separation, _ = one.model.surrogate.fly(flights, actor(one), 1.0, 1e9)
    hit = torch.tensor([episode["collision"] > 0.5 for episode in episodes])
    assert len(flights) == len(hit) and hit.sum() > 30
    assert separation[hit].max() < 6.5  # three looks a decision, at up to 7 m/s
    assert separation[~hit].min() > 4.0


def test_what_is_told_of_episodes_is_what_was_flown():
    one = learner("plane")
    _, episodes = flown(one)
    assert len(episodes) == ROWS
    assert all(episode["r"] < 0.0 and episode["l"] > 20 and episode["deviation_m"] > 0.0 for episode in episodes)
