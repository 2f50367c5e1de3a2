"""The rules that read the tracks: mirror symmetry, sides, several intruders, the filter, levels of information."""

import numpy as np
import pytest

from rss_gym import baselines, observation
from rss_gym.baselines.cbf import Cbf
from rss_gym.baselines.policy import Nothing
from rss_gym.core import Batch, decode
from rss_gym.eval.suites import DEGENERATE
from rss_gym.params import Params, ParamsError

RULES = ["orthogonal", "orca", "mvp", "cbf", "mpc", "qmdp"]
COUNT = 12


def flight(policy, steps=400, count=COUNT):
    """The batch before each decision and the actions; rows stop where they end."""
    batch = Batch(policy.params, count)
    batch.seed(np.arange(count, dtype=np.uint64))
    batch.reset(np.ones(count, bool))
    state, ended = None, np.zeros(count, bool)
    for _ in range(steps):
        actions, state = policy.predict(batch.observations, state)
        yield batch, actions, ended
        batch.step(decode(actions, batch.params, count), ~ended)
        ended = batch.episode["terminated"] | batch.episode["truncated"]
        if ended.all():
            return


def flown(policy, steps=400, count=COUNT):
    """The batch after the flight."""
    return list(flight(policy, steps, count))[-1][0]


def mirrored(observations, params):
    """The same encounters seen in a mirror: everything to the right is to the left."""
    names = [field.name for field in observation.fields(params)]
    return observations * np.array([-1.0 if "_right_" in name else 1.0 for name in names], np.float32)


@pytest.mark.parametrize(
    "family", [name for name in DEGENERATE if name not in ("exact-head-on", "tail-chase", "hovering")]
)
@pytest.mark.parametrize("information", ["oracle", "positions"])
@pytest.mark.parametrize("name", RULES)
def test_a_mirrored_encounter_gets_the_mirrored_action(name, information, family):
    """Where a side is decided by a tie there is no mirror image; those families are left to the next test."""
    policy = baselines.make(f"{name}@{information}", Params.of(families=family))
    acted = False
    image = None
    for batch, actions, _ in flight(policy, 120):
        other, image = policy.predict(mirrored(batch.observations, policy.params), image)
        np.testing.assert_allclose(other, actions * [1.0, -1.0], atol=1e-5)
        acted |= bool((np.abs(actions) > 0.05).any())
    assert acted or (information, family) == ("oracle", "equal-velocities")  # 30 m apart is clear


def observed(params, **values):
    """An observation of these SI values, zero for the rest; `_` of intruders is written for `.`."""
    table = observation.fields(params)
    names = [field.name for field in table]
    raw, out = np.zeros(len(table)), np.zeros(len(table), np.float32)
    for name, value in values.items():
        raw[names.index(name.replace("__", "."))] = value
    observation.transform(raw, observation.transforms(table), out)
    return out


def intruder(k, along_m, right_m, along_mps, right_mps=0.0, own_mps=3.0):
    """The fields of one intruder that is tracked without error; its velocity is over ground."""
    fields = {
        "present": 1.0, "warning": 1.0, "message_valid": 1.0, "track_valid": 1.0, "zone_radius_m": 120.0,
        "range_m": np.hypot(along_m, right_m), "track_position_along_m": along_m, "track_position_right_m": right_m,
        "track_velocity_along_mps": along_mps - own_mps, "track_velocity_right_mps": right_mps,
    }  # fmt: skip
    return {f"intruder_{k}__{name}": value for name, value in fields.items()}


def crossing(params, right_m, along_m=60.0):
    """An observation of an intruder on the opposite course, `right_m` to the right, known without error."""
    return observed(params, velocity_along_mps=3.0, cruise_mps=3.0, **intruder(0, along_m, right_m, -3.0))


@pytest.mark.parametrize("right_m", [-9.0, -4.0, 4.0, 9.0])
@pytest.mark.parametrize("information", ["oracle", "positions", "ranges"])
@pytest.mark.parametrize("name", RULES)
def test_the_smaller_displacement_is_chosen(name, information, right_m):
    """The intruder will pass on one side: the rule gives way to the other side."""
    policy = baselines.make(f"{name}@{information}")
    action, _ = policy.predict(crossing(policy.params, right_m, along_m=30.0))
    assert np.sign(action[1]) == -np.sign(right_m)


@pytest.mark.parametrize("name", RULES)
def test_an_intruder_that_passes_clear_or_is_past_changes_nothing(name):
    policy = baselines.make(f"{name}@oracle")
    for right_m, along_m in ((100.0, 40.0), (-100.0, 40.0), (2.0, -100.0)):
        action, _ = policy.predict(crossing(policy.params, right_m, along_m))
        np.testing.assert_allclose(action, 0.0, atol=1e-6)


@pytest.mark.parametrize("name", RULES)
def test_nobody_is_obeyed_without_a_warning_or_a_track(name):
    policy = baselines.make(name)
    for missing in ("warning", "track_valid"):
        fields = intruder(0, 30.0, 4.0, -3.0) | {f"intruder_0__{missing}": 0.0}
        action, _ = policy.predict(observed(policy.params, velocity_along_mps=3.0, cruise_mps=3.0, **fields))
        np.testing.assert_allclose(action, 0.0, atol=1e-6)


@pytest.mark.parametrize("family", ["exact-head-on", "tail-chase", "start-near-zone", "hovering"])
@pytest.mark.parametrize("name", RULES)
def test_on_true_states_no_rule_collides_in_the_corners(name, family):
    policy = baselines.make(f"{name}@oracle", Params.of(families=family))
    batch = flown(policy)
    if (name, family) != ("orthogonal", "hovering"):  # a hovering other has no direction to be orthogonal to
        assert not batch.episode["collision"].any()


# The orthogonal rule


def commanded_displacement(policy, observed_, state=None, steps=60):
    """Where the rule leads the way point if what it sees stays: the displacement at rest, along and right."""
    names = [field.name for field in observation.fields(policy.params)]
    table = observation.transforms(observation.fields(policy.params))
    at = [names.index("way_point_along_m"), names.index("way_point_right_m")]
    tracks = [
        (names.index(f"intruder_{k}.track_position_along_m"), names.index(f"intruder_{k}.track_position_right_m"))
        for k in range(policy.params.encounter.intruders)
    ]
    raw, values = observation.restored(observed_, observation.fields(policy.params)), observed_.copy()
    start = raw.copy()
    for _ in range(steps):
        action, state = policy.predict(values, state)
        step = policy.params.aircraft.speed_max_mps * policy.params.clock.decision_s * action
        raw[at] += step
        for pair in tracks:  # relative to the own position, which follows
            raw[list(pair)] = start[list(pair)] - raw[at]
        observation.transform(raw, table, values)
    return raw[at], state


@pytest.mark.parametrize("own_right_m", [-6.0, 6.0])
def test_the_side_is_that_of_the_aircraft_and_not_of_its_plan(own_right_m):
    """The aircraft is displaced across the line of the intruder's flight: it stays on that side."""
    policy = baselines.make("orthogonal:radius_m=40,lookahead_s=0")
    plan_right_m = -own_right_m / 2.0  # to the right of the intruder's line, where the aircraft is `own_right_m`
    seen = observed(
        policy.params, velocity_along_mps=3.0, cruise_mps=3.0, way_point_right_m=own_right_m - plan_right_m,
        **intruder(0, 30.0, -own_right_m, -3.0),
    )  # fmt: skip
    action, _ = policy.predict(seen)
    assert np.sign(action[1]) == np.sign(own_right_m)


def test_the_side_is_kept_while_warned_and_forgotten_after():
    policy = baselines.make("orthogonal:radius_m=40,lookahead_s=0")
    own = {"velocity_along_mps": 3.0, "cruise_mps": 3.0}
    left = observed(policy.params, **own, **intruder(0, 30.0, 3.0, -3.0))
    action, state = policy.predict(left)
    assert action[1] < 0.0
    right = observed(policy.params, **own, **intruder(0, 28.0, -3.0, -3.0))  # the track has moved across
    action, state = policy.predict(right, state)
    assert action[1] < 0.0
    past = observed(policy.params, **own, **intruder(0, -60.0, -3.0, -3.0))  # beyond the zone, still warned
    action, state = policy.predict(past, state)
    action, kept = policy.predict(right, state)
    assert action[1] < 0.0
    silent = observed(policy.params, **own, **(intruder(0, 28.0, -3.0, -3.0) | {"intruder_0__warning": 0.0}))
    _, state = policy.predict(silent, kept)
    action, _ = policy.predict(right, state)
    assert action[1] > 0.0


@pytest.mark.parametrize("radius_m", [20.0, 60.0, 110.0])
def test_no_displacement_is_clipped(radius_m):
    """From the far side the way to the edge is nearly twice the radius."""
    policy = baselines.make(f"orthogonal:radius_m={radius_m:g},lookahead_s=0")
    own = {"velocity_along_mps": 3.0, "cruise_mps": 3.0}
    _, state = policy.predict(observed(policy.params, **own, **intruder(0, 1.0, 1.0, -3.0)))
    moved, _ = commanded_displacement(
        policy, observed(policy.params, **own, **intruder(0, 1.0, -0.9 * radius_m, -3.0)), state, 200
    )
    assert moved[1] == pytest.approx(-0.9 * radius_m - np.sqrt(radius_m**2 - 1.0), rel=1e-3)


@pytest.mark.parametrize(
    "places",
    [
        [(20.0, 4.0, -3.0), (25.0, -30.0, -2.5), (10.0, -55.0, -3.5)],  # each way out leads into the next zone
        [(20.0, 12.0, -3.0), (25.0, 22.0, -2.5), (15.0, 45.0, -3.5)],
        [(30.0, -9.0, -3.0), (32.0, -5.0, -3.0), (28.0, -60.0, -3.0)],
    ],
)
def test_the_rule_obeys_all_of_three_intruders(places):
    """The way point that it leads to is outside the zone of everybody who flies past, in the order of any numbering."""
    radius_m = 40.0
    policy = baselines.make(f"orthogonal:radius_m={radius_m:g},lookahead_s=0", Params.of(intruders=3))
    ends = []
    for order in ([0, 1, 2], [2, 0, 1]):
        fields = {}
        for k, at in enumerate(order):
            fields |= intruder(k, *places[at])
        seen = observed(policy.params, velocity_along_mps=3.0, cruise_mps=3.0, **fields)
        moved, _ = commanded_displacement(policy, seen, steps=120)
        for along_m, right_m, _ in places:
            assert np.hypot(along_m - moved[0], right_m - moved[1]) >= radius_m - 0.1
        ends.append(moved)
    np.testing.assert_allclose(ends[0], ends[1], atol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", RULES)
def test_with_three_intruders_on_true_states_hardly_anybody_collides(name):
    batch = flown(baselines.make(f"{name}@oracle", Params.of(intruders=3)), count=100)
    assert batch.episode["collision"].sum() <= 2


@pytest.mark.parametrize("name", [name for name in RULES if name not in ("orthogonal", "mpc", "qmdp")])
def test_the_aircraft_flies_the_velocity_commanded(name):
    """The mean error of velocity over the flights is a fraction of the change commanded."""
    policy = baselines.make(name, Params.of(gust_mps=0.0))
    errors, changes = [], []
    for batch, actions, ended in flight(policy, 120):
        agent = batch.state.aircraft[~ended, 0]
        along = agent["along"][:, :2]
        right = np.stack([along[:, 1], -along[:, 0]], axis=1)
        limit = policy.params.aircraft.speed_max_mps
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
    """With a radius too small to matter, the filtered flight is the policy's own."""
    keywords = {"families": "parallel-pass", "gust_mps": 0.0}
    plain = baselines.make(base, Params.of(**keywords))
    filtered = baselines.make(f"cbf:radius_m=1,sigmas=0,lookahead_s=0.5+{base}", Params.of(**keywords))
    assert filtered.params == plain.params
    one, two = flown(plain, 60), flown(filtered, 60)
    apart = one.state.aircraft["position_m"][:, 0] - two.state.aircraft["position_m"][:, 0]
    assert np.linalg.norm(apart, axis=1).max() < 0.1


def test_the_filter_keeps_a_policy_that_does_not_look_from_colliding():
    collisions = {}
    for name in ("none", "cbf+none", "constant:right_m=12", "cbf+constant:right_m=12"):
        batch = flown(baselines.make(name, Params.of(families="crossing")), count=64)
        collisions[name] = int(batch.episode["collision"].sum())
    assert collisions["none"] >= 15 and collisions["cbf+none"] <= 1
    assert collisions["cbf+constant:right_m=12"] <= 1


class Idle:
    """A discrete policy, without a world, that keeps a state of its own kind."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros(np.shape(observation)[:-1], int), (state or 0) + 1


def test_the_filter_takes_any_object():
    params = Params.of()
    policy = Cbf(base=Idle(), base_params=Params.of(action="discrete"), params=params)
    batch = Batch(params, 5)
    batch.reset(np.ones(5, bool))
    actions, state = policy.predict(batch.observations)
    again, state = policy.predict(batch.observations, state)
    single, _ = policy.predict(batch.observations[2])
    np.testing.assert_array_equal(actions, again)
    np.testing.assert_array_equal(single, actions[2])
    assert state[1] == 2 and isinstance(policy.base, Idle) and not isinstance(policy.base, Nothing)


@pytest.mark.parametrize(("base", "words"), [(object(), "predict"), (Idle(), "base_params")])
def test_a_base_that_cannot_be_filtered_is_refused(base, words):
    with pytest.raises(ParamsError, match=words):
        Cbf(base=base)


# Specifications


def level(spec, params=None):
    """The level of information that the policy flies on."""
    return baselines.make(spec, params).params.interface.information


def test_the_information_is_part_of_the_name():
    assert level("orca") == "positions"
    assert level("orca@oracle:radius_m=12") == "oracle"
    assert baselines.make("orca@oracle:radius_m=12").radius_m == 12.0
    assert level("orca", Params.of(information="oracle")) == "oracle"
    assert level("orca@positions", Params.of(information="oracle")) == "positions"
    assert level("orca@oracle", Params.of(information="ranges")) == "oracle"
    assert level("modified-orthogonal@ranges") == "ranges"
    assert level("cbf+modified-orthogonal@ranges") == "ranges"
    assert baselines.make("cbf+orthogonal@oracle:radius_m=1e+2").base.radius_m == 100.0
    assert level("cbf:radius_m=9+mvp") == "positions"


def test_nothing_but_the_information_of_the_world_is_changed():
    params = Params.of(channel="outdoor", intruders=2, tracker="latest")
    assert baselines.make("orca", params).params == params
    assert baselines.make("orca@oracle", params).params == Params.of(params, information="oracle")
    assert baselines.make("orca", Params.of(params, action="discrete")).params == params  # it commands velocities


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("orca@orcale", ["'orcale'", "did you mean 'oracle'"]),
        ("modified-orthogonal", ["'modified-orthogonal'", "information 'positions'", "'ranges'"]),
        ("modified-orthogonal@positions", ["information 'positions'", "'ranges'"]),
        ("orca+mvp", ["only 'cbf'"]),
        ("cbf@oracle+mvp", ["only 'cbf'", "information"]),
        ("cbf+modified-orthogonal", ["'modified-orthogonal'", "information 'positions'"]),
        ("cbf+nonsense", ["'nonsense'", "unknown"]),
        ("cbf:base=1", ["no option 'base'"]),
        ("orca:radius_m=9,radius_m=12", ["'radius_m'", "'orca'", "twice"]),
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
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", [name for name in RULES if name != "qmdp"])
@pytest.mark.parametrize("information", ["positions", "ranges"])
def test_the_radius_is_held_against_the_zone_of_the_world_flown_in(name, information):
    """A longer reaction makes a zone of 200 m; 150 m are too much for the default one of 120 m."""
    params = Params.of(reaction_s=2.0)
    assert params.zone.radius_m == 200.0
    policy = baselines.make(f"{name}@{information}:radius_m=150", params)
    assert policy.params.zone.radius_m == 200.0
    with pytest.raises(ParamsError, match="zone radius 200"):
        baselines.make(f"{name}@{information}:radius_m=201", params)
