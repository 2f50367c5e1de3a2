"""What the families promise that tell the rules apart: when, how much, and that nothing else is touched."""

import functools

import numpy as np
import pytest
from scipy import stats

from rss_gym.core import Batch
from rss_gym.encounters import FAMILIES
from rss_gym.encounters.family import Complication, Family
from rss_gym.encounters.sampler import APART_M, STAGGER_S
from rss_gym.eval.suites import SUITES
from rss_gym.lanes import FRESH_S
from rss_gym.params import Params, ParamsError

N = 1000
PARAMS = Params()
RADIUS_M, TAIL_S = PARAMS.zone.radius_m, PARAMS.clock.tail_min_s
CRUISE_MPS = PARAMS.encounter.cruise_min_mps, PARAMS.encounter.cruise_max_mps


def fresh(n=N, **keywords):
    batch = Batch(Params.of(**keywords), n)
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.reset(np.ones(n, bool))
    return batch


def flight(batch):
    """Fly with no action, and yield the rows still flying before each decision is looked at."""
    done = np.zeros(batch.n, bool)
    while not done.all():
        batch.step(np.zeros((batch.n, 3)), ~done)
        yield ~done
        done |= batch.episode["terminated"] | batch.episode["truncated"]


def legs(aircraft):
    """Velocities (n, 2, 2) of the two legs of paths of three points, and when the second begins (n,)."""
    assert np.all(aircraft["path_points"] == 3)
    points, times = aircraft["path_m"][:, :3, :2], aircraft["path_s"][:, :3]
    return np.diff(points, axis=1) / np.diff(times, axis=1)[..., None], times[:, 1]


def angle(one, two):
    """Signed angle from the first horizontal vectors to the second, rad."""
    return np.arctan2(
        one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0], np.sum(one[..., :2] * two[..., :2], axis=-1)
    )


def bend(name):
    """Legs of the intruder, when it bends before the closest approach, and the planned range there."""
    batch = fresh(families=name)
    agent, intruder = batch.state.aircraft[:, 0], batch.state.aircraft[:, 1]
    velocities, bend_s = legs(intruder)
    own = agent["path_m"][:, 0] + agent["planned_mps"] * bend_s[:, None]
    assert np.all(agent["path_points"] == 2)
    before_s = batch.episode["approach_s"] - bend_s
    low, high = FAMILIES[name].complication.bend_s
    assert np.all((before_s >= low - 1e-9) & (before_s <= high + 1e-9))
    return velocities, np.linalg.norm(intruder["path_m"][:, 1] - own, axis=1)


def assert_uniform(values, low, high):
    """Sizes uniform in [low, high], signs even."""
    assert stats.kstest(abs(values), stats.uniform(low, high - low).cdf).pvalue > 1e-4
    assert stats.binomtest(int(np.sum(values > 0)), len(values)).pvalue > 1e-4


def entry_s(batch):
    """First time that the planned range is at most the zone's radius, in steps of 0.01 s: straight paths."""
    agent, intruder = batch.state.aircraft[:, 0], batch.state.aircraft[:, 1]
    r = intruder["path_m"][:, 0] - agent["path_m"][:, 0]
    v = intruder["planned_mps"] - agent["planned_mps"]
    times = np.arange(0.0, 80.0, 0.01)
    x, y = (r[:, axis, None] + v[:, axis, None] * times for axis in range(2))
    return times[np.argmax(x * x + y * y <= RADIUS_M**2, axis=1)]


# -- paths ------------------------------------------------------------------------------------------------------------


def test_late_turn_is_made_inside_the_zone():
    velocities, range_m = bend("late-turn")
    turn = angle(velocities[:, 0], velocities[:, 1])
    low, high = FAMILIES["late-turn"].complication.turn_rad
    assert np.all((abs(turn) >= low - 1e-9) & (abs(turn) <= high + 1e-9))
    assert stats.binomtest(int(np.sum(turn > 0)), N).pvalue > 1e-4
    assert np.all(range_m < RADIUS_M)


def test_late_turn_is_made_while_the_warning_is_open():
    batch = fresh(families="late-turn")
    warned, before = [], np.zeros(N, np.int64)
    for flying in flight(batch):
        now = batch.state.aircraft["leg"][:, 1].copy()
        warned.extend(batch.state.contacts["warning"][flying & (now > before), 0])
        before = now
    share = np.mean(warned)
    print(f"\nshare of {len(warned)} late turns that are made while the warning is open: {share}")
    assert len(warned) > 0.99 * N
    assert share > 0.95


def test_accelerating_changes_speed_inside_the_zone_and_within_the_limits():
    velocities, range_m = bend("accelerating")
    speeds = np.linalg.norm(velocities, axis=2)
    change = speeds[:, 1] - speeds[:, 0]
    low, high = FAMILIES["accelerating"].complication.speed_change_mps
    assert np.all((abs(change) >= low - 1e-9) & (abs(change) <= high + 1e-9))
    assert 0.3 < np.mean(change > 0) < 0.7
    assert np.all((speeds >= CRUISE_MPS[0] - 1e-9) & (speeds <= CRUISE_MPS[1] + 1e-9))
    np.testing.assert_allclose(angle(velocities[:, 0], velocities[:, 1]), 0.0, atol=1e-9)
    assert np.all(range_m < RADIUS_M)


def test_accelerating_is_flown():
    """At the closest approach the intruder is where the new speed has brought it; the limit of speed holds."""
    batch, low, high = fresh(200, families="accelerating", gust_mps=0.0), CRUISE_MPS[0], PARAMS.aircraft.speed_max_mps
    for flying in flight(batch):
        aircraft = batch.state.aircraft[flying, 1]
        speed = np.linalg.norm(aircraft["velocity_mps"], axis=1)
        assert np.all((speed > low - 0.5) & (speed <= high * (1 + 1e-12)))
        late = batch.episode["tick"][flying] * 0.1 >= batch.episode["approach_s"][flying]
        error_m = np.linalg.norm(aircraft["position_m"] - aircraft["planned_m"], axis=1)
        assert np.all(error_m[late] < 1.0)


def test_merging_intruders_come_one_after_another_and_follow_one_course():
    """Planned to stay 10 m apart from each other, which is more than a collision."""
    batch = fresh(200, families="merging", intruders=8)
    agent, intruders = batch.state.aircraft[:, 0], batch.state.aircraft[:, 1:]
    first_s = batch.episode["approach_s"]
    courses, offsets, arrivals = [], [], []
    for k in range(8):
        velocities, there_s = legs(intruders[:, k])
        np.testing.assert_allclose(there_s, first_s + k * STAGGER_S, rtol=1e-12)
        own = agent["path_m"][:, 0] + agent["planned_mps"] * there_s[:, None]
        offsets.append(np.linalg.norm((intruders[:, k]["path_m"][:, 1] - own)[:, :2], axis=1))
        start_m = np.linalg.norm(intruders[:, k]["path_m"][:, 0] - agent["path_m"][:, 0], axis=1)
        assert np.all(start_m >= 1.1 * 120.0 - 1e-5)
        if k == 0:  # the others arrive later and may come from farther away
            assert np.all(start_m <= np.hypot(1.6 * 120.0, offsets[k]) + 1e-5)
        courses.append(velocities[:, 1])
        arrivals.append(there_s)
        if k == 0:
            np.testing.assert_allclose(velocities[:, 1], velocities[:, 0], atol=1e-9)
        np.testing.assert_allclose(angle(courses[k], courses[0]), 0.0, atol=1e-9)
    assert np.max(offsets) <= FAMILIES["merging"].offset_m[1] + 1e-6
    times = np.arange(0.0, 140.0, 0.05)
    for i in range(0, 200, 10):
        places = []
        for k in range(8):
            aircraft, (velocities, there_s) = intruders[i, k], legs(intruders[i : i + 1, k])
            leg = np.where(times < there_s[0], 0, 1)
            places.append(aircraft["path_m"][1, :2] + velocities[0][leg] * (times - there_s[0])[:, None])
        own = agent["path_m"][i, 0, :2] + agent["planned_mps"][i, :2] * times[:, None]
        for k in range(8):
            end = times <= arrivals[k][i] + TAIL_S
            # The closest approach is the planned one, also after the turn.
            assert np.linalg.norm(places[k] - own, axis=1)[end].min() >= offsets[k][i] - 0.1 - 1e-6
            for other in range(k):
                assert np.linalg.norm(places[k] - places[other], axis=1)[end].min() >= APART_M - 1e-6
    directions = np.array([legs(intruders[:, k])[0][:, 0] for k in range(1, 8)])
    spread = angle(directions, np.array(courses[0])[None])
    assert np.mean(abs(spread) > 0.5) > 0.5
    assert APART_M > 2.0 * PARAMS.zone.collision_m


@pytest.mark.parametrize("intruders", [2, 5, 8])
def test_merging_encounters_can_always_be_drawn(intruders):
    """Where the first intruders leave no room for a later one, the encounter is drawn again."""
    batch = fresh(1000, families="merging", intruders=intruders)
    assert (batch.episode["family"] == 0).all()


# -- messages ---------------------------------------------------------------------------------------------------------


def test_deceitful_announces_a_turn_that_is_not_flown():
    batch = fresh(families="deceitful", intruder="gnss")  # no fix moves the solution between message and look
    velocities, _ = legs(batch.state.aircraft[:, 1])
    np.testing.assert_allclose(velocities[:, 0], velocities[:, 1], rtol=1e-9)
    cosine, sine = batch.state.contacts["false_turn"][:, 0].T
    announced = np.arctan2(sine, cosine)
    assert_uniform(announced, *FAMILIES["deceitful"].complication.announced_rad)
    lies = truths = 0
    for flying in flight(batch):
        rows = flying & batch.state.contacts["warning"][:, 0]
        contact, aircraft = batch.state.contacts[rows, 0], batch.state.aircraft[rows, 1]
        assert np.array_equal(contact["position_m"], aircraft["solution_m"])
        ahead = PARAMS.messages.announce_s * (aircraft["planned_mps"] + aircraft["velocity_error_mps"])
        stated_ahead = contact["way_point_m"] - contact["position_m"]
        lie = np.where(aircraft["leg"] > 0, -announced[rows], 0.0)  # positive angles of `turned` are to the right
        for stated, true in ((contact["velocity_mps"], aircraft["solution_mps"]), (stated_ahead, ahead)):
            assert_turned(stated, true, lie)
        error_mps = np.linalg.norm(contact["velocity_mps"] - aircraft["solution_mps"], axis=1)
        speed_mps = np.linalg.norm(aircraft["solution_mps"], axis=1)
        np.testing.assert_allclose(error_mps, 2.0 * speed_mps * np.sin(0.5 * abs(lie)), atol=1e-9)
        lies, truths = lies + np.sum(lie != 0.0), truths + np.sum(lie == 0.0)
    assert min(lies, truths) > 10 * N


def assert_turned(stated, true, by_rad):
    """Vectors (n, 3) of one length, at these angles."""
    difference = angle(true, stated) - by_rad
    np.testing.assert_allclose(np.sin(0.5 * difference), 0.0, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(stated, axis=1), np.linalg.norm(true, axis=1), rtol=1e-9, atol=1e-9)


def test_deceit_leaves_flight_and_radio_alone():
    """`outage` draws the same encounters: both fly the same, and their channels have the same noise."""
    honest, liar = fresh(100, families="outage"), fresh(100, families="deceitful")
    for _, flying in zip(flight(honest), flight(liar), strict=True):
        for column in ("coloured_db", "wander"):
            assert np.array_equal(honest.state.links[column][flying, 0], liar.state.links[column][flying, 0])
        np.testing.assert_allclose(
            honest.state.aircraft["position_m"][flying], liar.state.aircraft["position_m"][flying], atol=1e-6
        )


# -- link -------------------------------------------------------------------------------------------------------------


def test_onsets_are_about_the_entry_into_the_zone():
    for name, column in (("path-loss-jump", "jump_s"), ("outage", "silent_s")):
        batch = fresh(families=name)
        records = batch.state.links[:, 0] if column == "jump_s" else batch.state.contacts[:, 0]
        after_s = records[column] - entry_s(batch)
        low, high = FAMILIES[name].complication.onset_s
        assert stats.kstest(after_s, stats.uniform(low, high - low).cdf).pvalue > 1e-4
    batch = fresh(families="outage")
    low, high = FAMILIES["outage"].complication.outage_s
    spans_s = batch.state.contacts["silent_until_s"][:, 0] - batch.state.contacts["silent_s"][:, 0]
    assert stats.kstest(spans_s, stats.uniform(low, high - low).cdf).pvalue > 1e-4
    jump = fresh(families="path-loss-jump").state.links["jump"]
    assert_uniform(jump[:, 0], *FAMILIES["path-loss-jump"].complication.path_loss_jump)
    assert not jump[:, 1:].any()  # the links to the nodes are as they were


@functools.cache
def jumps(information):
    """A flight over a link without noise, each sample inverted alone: before and after the jump."""
    channel = {"white_variance_db2": 0.0, "coloured_variance_db2": 1e-6, "path_loss_wander": 0.0}
    batch = fresh(100, families="path-loss-jump", channel=channel, estimator="ls", information=information)
    link, rows = batch.state.links[:, 0], []
    for flying in flight(batch):
        before = batch.episode["tick"] * 0.1 - 0.5  # when the decision began; the jump waits for the next one
        distance = np.linalg.norm(
            batch.state.aircraft["position_m"][:, 0] - batch.state.aircraft["position_m"][:, 1], axis=1
        )
        jump = np.where(before >= link["jump_s"], link["jump"], 0.0)
        stated = batch.seen.others["path_loss_factor"][:, 0]
        rows.append(np.column_stack([jump, distance, link["range_m"], stated])[flying])
    return np.concatenate(rows)


def test_a_jump_biases_the_range_as_the_path_loss_predicts():
    """ln d' = (1 + jump / gamma) ln d."""
    jump, distance, range_m, _ = jumps("positions").T
    gamma = PARAMS.channels[0].path_loss_factor
    plain = (distance > 10.0) & (distance ** (1.0 + jump / gamma) < 900.0)
    assert np.sum(plain & (jump != 0.0)) > 1000
    assert np.sum(plain & (jump == 0.0)) > 1000
    predicted = (1.0 + jump / gamma) * np.log(distance)
    np.testing.assert_allclose(np.log(range_m)[plain], predicted[plain], atol=1e-3)


def test_the_jump_is_known_to_the_oracle_alone():
    gamma = PARAMS.channels[0].path_loss_factor
    assert np.all(jumps("positions")[:, 3] == gamma)
    jump, _, _, stated = jumps("oracle").T
    seen = stated - gamma
    same = np.isclose(seen, jump, atol=1e-12)
    assert np.mean(same) > 0.98  # but for the decision in which it happens
    assert np.all(same | ((jump == 0.0) & (abs(seen) >= 0.15 - 1e-12)))


def test_in_an_outage_there_is_no_message_and_the_range_is_only_predicted():
    batch = fresh(300, families="outage", decision_s=0.1)
    link, contact = batch.state.links[:, 0], batch.state.contacts[:, 0]
    silent_ticks = np.zeros(batch.n, np.int64)
    grown, reopened = 0, 0
    before, was_silent, was_warned = link.copy(), np.zeros(batch.n, bool), contact["warning"].copy()
    for flying in flight(batch):
        now_s = batch.episode["tick"] * 0.1
        silent = flying & (now_s >= contact["silent_s"]) & (now_s < contact["silent_until_s"])
        silent_ticks += silent
        # Once the message held is old there is no psi either.
        plain = silent & was_silent & ~((contact["age_s"] <= FRESH_S + 0.1) & contact["valid"])
        np.testing.assert_allclose(link["p_dd"][plain] - before["p_dd"][plain], PARAMS.ranging.process_noise_m2)
        assert np.array_equal(link["range_m"][plain], before["range_m"][plain])
        grown += np.sum(plain)
        assert np.all(contact["age_s"][silent] > 0.0)
        assert np.all((contact["age_s"] == 0.0)[flying & ~silent] == contact["warning"][flying & ~silent])
        reopened += np.sum(flying & ~silent & was_silent & was_warned & (contact["age_s"] == 0.0))
        before, was_silent, was_warned = link.copy(), silent, contact["warning"].copy()
    assert grown > 300 * 10
    assert reopened > 100
    low, high = FAMILIES["outage"].complication.outage_s
    assert silent_ticks.max() <= 10.0 * high + 1
    whole = contact["silent_s"] >= 0.0
    assert np.all(silent_ticks[whole] >= 10.0 * low - 1)


# -- together ---------------------------------------------------------------------------------------------------------


def test_each_intruder_has_the_complication_of_its_own_family():
    batch = fresh(300, families=("crossing", "deceitful", "outage"), intruders=4)
    family = batch.state.aircraft["family"][:, 1:]
    assert np.bincount(family.ravel(), minlength=3).min() > 100
    assert np.array_equal(family[:, 0], batch.episode["family"])
    assert np.array_equal(batch.state.contacts["false_turn"][..., 1] != 0.0, family == 1)
    assert np.array_equal(batch.state.contacts["silent_until_s"] > batch.state.contacts["silent_s"], family == 2)


@pytest.mark.slow
@pytest.mark.parametrize("suite", ["separating-v0", "merging-v0"])
def test_between_a_fifth_and_three_fifths_collide_if_nobody_acts(suite):
    """In each family; the radio is left out of it."""
    params = SUITES[suite].params
    batch = fresh(
        3000,
        families=params.encounter.families,
        intruders=params.encounter.intruders,
        intruders_min=params.encounter.intruders_min,
        agent="gnss",
        intruder="gnss",
        estimator="ls",
        channel={"sensitivity_dbm": 0.0},
    )
    for _ in flight(batch):
        pass
    for index, name in enumerate(SUITES[suite].families):
        mine = batch.episode["family"] == index
        share = np.mean(batch.episode["collision"][mine])
        print(f"\nshare of {mine.sum()} {name} encounters that collide under zero action: {share:.3f}")
        assert 0.2 < share < 0.6


def test_one_law_of_turns():
    with pytest.raises(ParamsError, match="turn_rad"):
        Family(summary="", weight=0.0, turn_rad=(0.5, 1.0), complication=Complication())
