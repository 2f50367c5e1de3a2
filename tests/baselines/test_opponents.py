"""The rules that need positions: specifications, mirror symmetry, the smaller displacement, the filter, the tracks."""

import numpy as np
import pytest

from rss_gym import baselines, observation
from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.policy import Nothing
from rss_gym.baselines.range_only import PROBABILITY
from rss_gym.core import Batch, decode
from rss_gym.eval.suites import DEGENERATE
from rss_gym.params import Params, ParamsError

RULES = [name for name, kind in baselines.POLICIES.items() if kind.reads_positions]
COUNT = 12


def flight(policy, steps=400, count=COUNT):
    """The batch before each decision and the actions; rows stop where they end."""
    batch = Batch(policy.world, count)
    batch.seed(np.arange(count, dtype=np.uint64))
    batch.reset(np.ones(count, bool))
    state, ended = None, np.zeros(count, bool)
    for _ in range(steps):
        actions, state = policy.predict(batch.observations, state)
        yield batch, actions, ended
        batch.step(decode(actions, batch.params, count), ended)
        ended = batch.episode["terminated"] | batch.episode["truncated"]
        if ended.all():
            return


def flown(policy, steps=400, count=COUNT):
    """The batch after the flight."""
    return list(flight(policy, steps, count))[-1][0]


def mirrored(observations, world):
    """The same encounters seen in a mirror: everything to the right is to the left."""
    names = [field.name for field in observation.fields(world)]
    flip = np.array([-1.0 if "_right_" in name or name == "turn_sin" else 1.0 for name in names], np.float32)
    return observations * flip


def test_these_are_the_rules():
    assert {"orthogonal", "orca", "mvp", "cbf", "mpc"} <= set(RULES)


@pytest.mark.parametrize(
    "family", [name for name in DEGENERATE if name not in ("exact-head-on", "tail-chase", "hovering")]
)
@pytest.mark.parametrize("track", ["oracle", "paper"])
@pytest.mark.parametrize("name", RULES)
def test_a_mirrored_encounter_gets_the_mirrored_action(name, track, family):
    """Where a side is decided by a tie there is no mirror image; those families are left to the next test."""
    policy = baselines.make(f"{name}@{track}", Params.of(families=family))
    acted = False
    image = None
    for batch, actions, _ in flight(policy, 120):
        other, image = policy.predict(mirrored(batch.observations, policy.world), image)
        np.testing.assert_allclose(other, actions * [1.0, -1.0], atol=1e-5)
        acted |= bool((np.abs(actions) > 0.05).any())
    assert acted or (track, family) == ("oracle", "equal-velocities")  # 30 m apart is clear


@pytest.mark.parametrize("family", ["start-near-zone", "crossing"])
@pytest.mark.parametrize("name", RULES)
def test_on_ranges_alone_too_once_the_sides_are_told_apart(name, family):
    """As long as both sides are as probable the choice is a tie; what the rule itself remembers of that is cleared."""
    policy = baselines.make(f"{name}@range", Params.of(families=family))
    batch, compared = Batch(policy.world, COUNT), 0
    batch.seed(np.arange(COUNT, dtype=np.uint64))
    batch.reset(np.ones(COUNT, bool))
    memory, one, two = (np.zeros((COUNT, policy.columns)) for _ in range(3))
    rule = slice(policy.columns - policy.rule.columns, None)
    for _ in range(100):
        seen = batch.observations.copy()
        share = policy.sides(observation.split(seen, policy.world), memory)[:, 0, :, PROBABILITY]
        here, one = policy.predict(seen, one)
        there, two = policy.predict(mirrored(seen, policy.world), two)
        one[:, rule] = two[:, rule] = 0.0
        apart = np.abs(share[:, 0] - share[:, 1]) > 0.1
        np.testing.assert_allclose(there[apart], here[apart] * [1.0, -1.0], atol=1e-4)
        compared += int((apart & (np.abs(here) > 0.05).any(axis=1)).sum())
        batch.step(decode(here, policy.world, COUNT), batch.episode["terminated"] | batch.episode["truncated"])
    assert compared > 20


def crossing(world, right_m, along_m=60.0, own_mps=3.0, other_mps=-3.0):
    """An observation of an intruder on the opposite course, `right_m` to the right, known without error."""
    names = [field.name for field in observation.fields(world)]
    scale = {field.name: field.scale for field in observation.fields(world)}
    values = np.zeros(len(names), np.float32)
    known = {
        "velocity_along_mps": own_mps, "cruise_mps": own_mps, "turn_cos": 1.0, "intruder_0.present": 1.0,
        "intruder_0.range_m": np.hypot(along_m, right_m), "intruder_0.warning": 1.0, "intruder_0.message_valid": 1.0,
        "intruder_0.zone_radius_m": 120.0, "intruder_0.message_velocity_along_mps": other_mps,
        "intruder_0.message_position_along_m": along_m, "intruder_0.message_position_right_m": right_m,
    }  # fmt: skip
    for name, value in known.items():
        values[names.index(name)] = value / scale[name]
    return values


@pytest.mark.parametrize("right_m", [-9.0, -4.0, 4.0, 9.0])
@pytest.mark.parametrize("track", ["oracle", "paper"])
@pytest.mark.parametrize("name", RULES)
def test_the_smaller_displacement_is_chosen(name, track, right_m):
    """The intruder will pass on one side: the rule gives way to the other side."""
    policy = baselines.make(f"{name}@{track}")
    action, _ = policy.predict(crossing(policy.world, right_m, along_m=40.0))
    assert np.sign(action[1]) == -np.sign(right_m)


@pytest.mark.parametrize("name", RULES)
def test_an_intruder_that_passes_clear_or_is_past_changes_nothing(name):
    policy = baselines.make(f"{name}@oracle")
    for right_m, along_m in ((100.0, 40.0), (-100.0, 40.0), (2.0, -100.0)):
        action, _ = policy.predict(crossing(policy.world, right_m, along_m))
        np.testing.assert_allclose(action, 0.0, atol=1e-6)


@pytest.mark.parametrize("family", ["exact-head-on", "tail-chase", "start-near-zone", "hovering"])
@pytest.mark.parametrize("name", RULES)
def test_on_true_states_no_rule_collides_in_the_corners(name, family):
    policy = baselines.make(f"{name}@oracle", Params.of(families=family))
    batch = flown(policy)
    if (name, family) != ("orthogonal", "hovering"):  # a hovering other has no direction to be orthogonal to
        assert not batch.episode["collision"].any()


@pytest.mark.parametrize("name", [name for name in RULES if name not in ("orthogonal", "mpc")])
def test_the_aircraft_flies_the_velocity_commanded(name):
    """The mean error of velocity over the flights is a fraction of the change commanded."""
    policy = baselines.make(name, Params.of(gust_mps=0.0))
    errors, changes = [], []
    for batch, actions, ended in flight(policy, 120):
        agent = batch.world.aircraft[~ended, 0]
        along = agent["along"][:, :2]
        right = np.stack([along[:, 1], -along[:, 0]], axis=1)
        limit = policy.world.aircraft.speed_max_mps
        wanted = agent["planned_mps"][:, :2] + limit * (actions[~ended, :1] * along + actions[~ended, 1:] * right)
        scale = np.maximum(np.linalg.norm(wanted, axis=1, keepdims=True) / limit, 1.0)
        errors.append(np.linalg.norm(wanted / scale - agent["velocity_mps"][:, :2], axis=1))
        changes.append(np.linalg.norm(limit * actions[~ended], axis=1))
    errors, changes = np.concatenate(errors), np.concatenate(changes)
    steered = changes > 0.2
    assert steered.sum() > 100
    print(f"{name}: mean change {changes[steered].mean():.2f} m/s, mean error {errors[steered].mean():.2f} m/s")
    assert errors[steered].mean() < 0.6 * changes[steered].mean()


# The filter round a policy


@pytest.mark.parametrize("base", ["none", "constant:right_m=12", "orthogonal:radius_m=60", "brake"])
def test_the_filter_leaves_a_policy_alone_where_nobody_is_near(base):
    """With a radius too small to matter, the filtered flight is the policy's own to the way the way point is led."""
    keywords = {"families": "parallel-pass", "gust_mps": 0.0}
    plain = baselines.make(base, Params.of(**keywords))
    filtered = baselines.make(f"cbf:radius_m=1,sigmas=0,lookahead_s=0.5+{base}", Params.of(**keywords))
    assert filtered.world.interface.action == "velocity" and filtered.world.interface.track == "paper"
    one, two = flown(plain, 60), flown(filtered, 60)
    apart = one.world.aircraft["position_m"][:, 0] - two.world.aircraft["position_m"][:, 0]
    assert np.linalg.norm(apart, axis=1).max() < 4.0


def test_the_filter_keeps_a_policy_that_does_not_look_from_colliding():
    collisions = {}
    for name in ("none", "cbf+none", "constant:right_m=12", "cbf+constant:right_m=12"):
        batch = flown(baselines.make(name, Params.of(families="crossing")), count=64)
        collisions[name] = int(batch.episode["collision"].sum())
    assert collisions["none"] >= 15 and collisions["cbf+none"] <= 1
    assert collisions["cbf+constant:right_m=12"] <= 1


def test_the_filter_takes_any_object():
    class Idle:
        """A discrete policy with a state of its own kind."""

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.zeros(np.shape(observation)[:-1], int), (state or 0) + 1

    world = Params.of()
    policy = Cbf(base=Idle(), base_world=Params.of(action="discrete"), world=Params.of(action="velocity"))
    batch = Batch(world, 5)
    batch.reset(np.ones(5, bool))
    actions, state = policy.predict(batch.observations)
    again, state = policy.predict(batch.observations, state)
    single, _ = policy.predict(batch.observations[2])
    np.testing.assert_array_equal(actions, again)
    np.testing.assert_array_equal(single, actions[2])
    assert state[1] == 2 and isinstance(policy.base, Idle) and not isinstance(policy.base, Nothing)


# Specifications


def test_a_track_is_part_of_the_name():
    assert baselines.make("orca").world.interface.track == "paper"
    assert baselines.make("orca@oracle:radius_m=12").world.interface.track == "oracle"
    assert baselines.make("orca@oracle:radius_m=12").radius_m == 12.0
    assert baselines.make("orca", Params.of(track="oracle")).world.interface.track == "oracle"
    assert baselines.make("orca@paper", Params.of(track="oracle")).world.interface.track == "paper"
    assert baselines.make("modified-orthogonal").world.interface.track == "range"
    assert baselines.make("cbf+orthogonal@oracle:radius_m=1e+2").base.radius_m == 100.0
    assert baselines.make("cbf:radius_m=9+mvp").world.interface.track == "paper"


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("cbf+none@range", ["'cbf+none@range'", "track 'range'", "oracle, paper"]),
        ("orca@orcale", ["'orcale'", "did you mean 'oracle'"]),
        ("modified-orthogonal@paper", ["track 'paper'", "range"]),
        ("orca+mvp", ["only 'cbf'"]),
        ("cbf@oracle+mvp", ["only 'cbf'", "track"]),
        ("cbf+modified-orthogonal", ["track 'range'"]),
        ("cbf+nonsense", ["'nonsense'", "unknown"]),
        ("cbf:base=1", ["no option 'base'"]),
        ("orca:radius_m=121", ["121", "zone radius 120"]),
        ("mpc:radius_m=121", ["121", "zone radius 120"]),
        ("mpc:lookahead_s=0", ["lookahead_s", "0.0"]),
    ],
)
def test_bad_specifications_are_refused_in_one_sentence(spec, words):
    with pytest.raises(ParamsError) as caught:
        baselines.make(spec)
    for word in words:
        assert word in str(caught.value)
