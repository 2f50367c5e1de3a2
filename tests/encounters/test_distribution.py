"""The published distribution of encounters: limits, closest approaches, symmetry, shares. Paths recomputed in NumPy."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from rss_gym import encounters
from rss_gym.core import Batch
from rss_gym.encounters.sampler import BEYOND_S
from rss_gym.eval.suites import SEPARATING
from rss_gym.params import Encounter, Params, ParamsError
from rss_gym.state import MAX_WAY_POINTS

N = 4000
FLOWN = 1000  # of them, by brute force
ENCOUNTER, CLOCK = Params().encounter, Params().clock
START_MIN_M = ENCOUNTER.start_range_min * ENCOUNTER.start_range_unit_m
START_MAX_M = ENCOUNTER.start_range_max * ENCOUNTER.start_range_unit_m
# The laws that are drawn from; the hand-written encounters obey no limits and stay out of `mixed`.
LAWS = {name: family for name, family in encounters.FAMILIES.items() if family.script is None}
MIXED = {name: family for name, family in LAWS.items() if family.weight > 0.0}  # the rest has to be named
SCRIPTS = {name: family.script for name, family in encounters.FAMILIES.items() if family.script is not None}
NAMES = [*LAWS, encounters.MIXED]
BENT = [name for name, f in LAWS.items() if f.turn_rad is not None or (f.complication and f.complication.bends)]
STRAIGHT = [name for name in LAWS if name not in ("turning", "late-turn", "accelerating")]  # a single intruder
SPATIAL = ["head-on", "turning", "no-conflict", encounters.MIXED]  # flown in 3-D too: their vertical laws differ
SIGMAS = 4.5  # of a statistic that is normal under the published law: 7e-6 two-sided, on fixed seeds


def fresh(n=N, **keywords):
    batch = Batch(Params.of(**keywords), n)
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.reset(np.ones(n, bool))
    return batch


def path_at(aircraft, times_s):
    """Position and velocity on the predefined trajectories of n aircraft at times (n, m); two (n, m, 3) arrays.

    Beyond its last way point a path goes straight on.
    """
    path, due, points = aircraft["path_m"], aircraft["path_s"], aircraft["path_points"]
    position = velocity = np.zeros((*times_s.shape, 3))
    for leg in range(points.max() - 1):
        flown = (leg < points - 1)[:, None] & ((times_s >= due[:, leg, None]) | (leg == 0))
        span_s = np.where(leg < points - 1, due[:, leg + 1] - due[:, leg], 1.0)
        v = ((path[:, leg + 1] - path[:, leg]) / span_s[:, None])[:, None]
        here = path[:, leg, None] + v * (times_s - due[:, leg, None])[..., None]
        position, velocity = np.where(flown[..., None], here, position), np.where(flown[..., None], v, velocity)
    return position, velocity


def relative(agent, intruder, times_s):
    """Position and velocity of the intruders as seen from the agents, on predefined trajectories."""
    own, own_v = path_at(agent, times_s)
    position, velocity = path_at(intruder, times_s)
    return position - own, velocity - own_v


def least_separation(agent, intruder, approach_s, end_s):
    """By brute force: steps of 0.1 s over the flight, through the planned closest approach exactly."""
    least = np.full(len(agent), np.inf)
    for part in np.array_split(np.arange(len(agent)), max(1, len(agent) // 250)):
        ticks = 0.1 * np.arange(-750, int(10.0 * np.max(end_s - approach_s)) + 1)
        times = np.clip(approach_s[part, None] + ticks, 0.0, end_s[part, None])
        r, _ = relative(agent[part], intruder[part], times)
        least[part] = np.sqrt(np.sum(r * r, axis=2).min(axis=1))
    return least


@functools.cache
def drawn(name, planar=True, intruders=1):
    """Encounters of a family, and what NumPy reads from the last intruder's path: one array per quantity."""
    batch = fresh(families=name, planar=planar, intruders=intruders, n=N if intruders == 1 else 800)
    agent, intruder = batch.state.aircraft[:, 0], batch.state.aircraft[:, -1]
    # Each intruder's path is laid until `BEYOND_S` after its closest approach.
    rows = np.arange(batch.n)
    approach_s = intruder["path_s"][rows, intruder["path_points"] - 1] - BEYOND_S
    end_s = batch.episode["ticks"] * batch.params.clock.tick_s
    now = approach_s[:, None]
    (own, own_v), (_, v) = path_at(agent, now), path_at(intruder, now)
    own_v, v = own_v[:, 0], v[:, 0]
    r, closing = (x[:, 0] for x in relative(agent, intruder, now))
    speed = np.linalg.norm(closing, axis=1)
    # What a straight extrapolation of the states 20 s earlier makes of the closest approach.
    before, guess = (x[:, 0] for x in relative(agent, intruder, now - 20.0))
    share = np.sum(before * guess, axis=1) / np.sum(guess * guess, axis=1)
    return SimpleNamespace(
        approach_s=approach_s,
        first_approach_s=batch.episode["approach_s"],
        end_s=end_s,
        family=batch.episode["family"],
        own=own[:, 0],
        speeds=np.linalg.norm([own_v, v], axis=2),
        heading=np.arctan2(own_v[:, 1], own_v[:, 0]),
        crossing=np.arctan2(own_v[:, 0] * v[:, 1] - own_v[:, 1] * v[:, 0], np.sum(own_v * v, axis=1)),
        closing=speed,
        miss=np.linalg.norm(r, axis=1),
        along=np.sum(r * closing, axis=1) / speed,
        horizontal=(r[:, 1] * closing[:, 0] - r[:, 0] * closing[:, 1]) / speed,
        vertical=r[:, 2],
        start=np.linalg.norm(relative(agent, intruder, 0.0 * now)[0][:, 0], axis=1),
        least=functools.cache(
            lambda: least_separation(agent[:FLOWN], intruder[:FLOWN], approach_s[:FLOWN], end_s[:FLOWN])
        ),
        extrapolated=np.where(approach_s > 20.0, np.linalg.norm(before - guess * share[:, None], axis=1), np.nan),
    )


def assert_limits(d):
    """The limits that every accepted draw meets."""
    assert np.all(d.closing >= ENCOUNTER.closing_min_mps - 1e-9)
    assert np.all(d.closing <= 2.0 * ENCOUNTER.cruise_max_mps + 1e-9)
    assert np.all(d.approach_s <= ENCOUNTER.time_to_approach_max_s + 1e-9)
    assert np.all(d.approach_s > 0.0)
    assert np.all(d.speeds >= ENCOUNTER.cruise_min_mps - 1e-9)
    assert np.all(d.speeds <= ENCOUNTER.cruise_max_mps + 1e-9)
    # The start range along the approach; the miss distance comes on top.
    assert np.all(d.start >= START_MIN_M - 1e-5)
    assert np.all(d.start <= np.hypot(START_MAX_M, d.miss) + 1e-5)
    # The planned approach is where the paths are nearest: perpendicular, and nowhere 0.1 m nearer in the flight.
    np.testing.assert_allclose(d.along, 0.0, atol=1e-6)
    assert np.all(d.least() <= d.miss[:FLOWN] + 1e-9)
    assert np.all(d.least() >= d.miss[:FLOWN] - 0.1 - 1e-6)


def assert_symmetric(values):
    """As many positive as negative ones."""
    positive = np.sum(values > 0.0)
    assert abs(positive - 0.5 * len(values)) < SIGMAS * 0.5 * np.sqrt(len(values))


@pytest.mark.parametrize(
    ("name", "planar"), [(name, True) for name in NAMES] + [(name, False) for name in SPATIAL], ids=str
)
def test_limits_and_planned_closest_approach(name, planar):
    d = drawn(name, planar)
    assert_limits(d)
    np.testing.assert_allclose(d.approach_s, d.first_approach_s, rtol=1e-12)
    np.testing.assert_allclose(d.own, np.tile([0.0, 0.0, ENCOUNTER.altitude_m], (N, 1)), atol=1e-9)
    # The clock runs out at the first decision not before the approach and a tail that is drawn.
    late = d.end_s - d.approach_s
    assert np.all((late > CLOCK.tail_min_s - 1e-6) & (late < CLOCK.tail_max_s + CLOCK.decision_s))
    spread = stats.uniform(CLOCK.tail_min_s, CLOCK.tail_max_s - CLOCK.tail_min_s + CLOCK.decision_s)
    assert stats.kstest(late, spread.cdf).statistic < 0.05
    if planar:
        assert np.all(d.vertical == 0.0)


@pytest.mark.parametrize("name", list(LAWS))
def test_closest_approaches_are_those_of_the_law(name):
    """Signs are even; the share of conflicts and the spread of the others are as published."""
    family, d, limit = LAWS[name], drawn(name), ENCOUNTER.conflict_offset_m
    low, high = family.offset_m or (0.0, ENCOUNTER.horizontal_offset_m)
    size = abs(d.horizontal)
    assert_symmetric(d.horizontal)
    assert np.all(size <= max(high, limit) + 1e-6)
    if family.conflict_share == 0.0:
        assert np.all(size >= low - 1e-6)
    # Beyond the conflicts' offsets a share (high - limit) / high of the others is found.
    others = size > limit
    share = (1.0 - family.conflict_share) * (high - max(low, limit)) / (high - low)
    assert abs(np.mean(others) - share) < SIGMAS * np.sqrt(max(share * (1.0 - share), 1e-12) / N) + 1e-9
    if name in STRAIGHT:  # redrawn turns prefer no offset over another
        uniform_law = stats.uniform(max(low, limit), high - max(low, limit))
        assert stats.kstest(size[others], uniform_law.cdf).pvalue > 1e-4
        if family.conflict_share > 0.0:
            assert stats.kstest(size[~others], stats.uniform(0.0, limit).cdf).pvalue > 1e-4


@pytest.mark.parametrize("name", list(LAWS))
def test_crossing_angles(name):
    """In the family's range, both sides alike, and uniform where no speeds can make a draw too slow."""
    family, d = LAWS[name], drawn(name)
    low, high = family.crossing_rad
    size = abs(d.crossing)
    assert np.all((size >= low - 1e-6) & (size <= high + 1e-6))
    if high - low > 0.0:
        assert_symmetric(d.crossing)
    # Two aircraft at cruise_min close at 2 v sin(angle / 2): fast enough for the longest start range from here on.
    slowest = START_MAX_M / ENCOUNTER.time_to_approach_max_s
    safe = max(low, 2.0 * np.arcsin(slowest / (2.0 * ENCOUNTER.cruise_min_mps)))
    if name in STRAIGHT and high - safe > 0.1:
        assert stats.kstest(size[size > safe], stats.uniform(safe, high - safe).cdf).pvalue > 1e-4


def test_headings_are_uniform():
    d = drawn("mixed")
    assert stats.kstest(d.heading, stats.uniform(-np.pi, 2.0 * np.pi).cdf).pvalue > 1e-4


def test_vertical_offsets_in_space():
    d = drawn("no-conflict", False)
    assert_symmetric(d.vertical)
    assert stats.kstest(abs(d.vertical), stats.uniform(0.0, ENCOUNTER.vertical_offset_m).cdf).pvalue > 1e-4
    d = drawn("head-on", False)
    conflict = abs(d.horizontal) <= ENCOUNTER.conflict_offset_m
    assert np.mean(abs(d.vertical[conflict]) <= 0.5 * ENCOUNTER.conflict_offset_m) > 0.9


def test_turns_defeat_straight_extrapolation():
    """From the states 20 s before the closest approach, both still before their turns."""
    d = drawn("turning")
    known = ~np.isnan(d.extrapolated)
    conflict = known & (d.miss <= ENCOUNTER.conflict_offset_m)
    assert np.sum(conflict) > 1000
    assert np.mean(d.extrapolated[conflict] > 10.0) > 0.8
    for name in STRAIGHT:
        d = drawn(name)
        known = ~np.isnan(d.extrapolated)
        np.testing.assert_allclose(d.extrapolated[known], d.miss[known], atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_paths_are_polylines_at_constant_speed(name):
    for row in fresh(200, families=name, intruders=2).state.aircraft:
        for a, aircraft in enumerate(row):
            points = aircraft["path_points"]
            assert 2 <= points <= MAX_WAY_POINTS
            times, path = aircraft["path_s"][:points], aircraft["path_m"][:points]
            assert times[0] == 0.0
            assert np.all(np.diff(times) > 0.0)
            speeds = np.linalg.norm(np.diff(path, axis=0), axis=1) / np.diff(times)
            if name != "accelerating":
                np.testing.assert_allclose(speeds, speeds[0], rtol=1e-9)
            assert np.ptp(path[:, 2]) == 0.0
            np.testing.assert_array_equal(aircraft["position_m"], path[0])
            if name != "mixed":
                assert points == (3 if name in BENT and (a > 0 or name == "turning") else 2)


@pytest.mark.slow
@pytest.mark.parametrize("intruders", range(2, 9))
def test_every_intruder_is_within_the_limits(intruders):
    """The last of 2-8 intruders; the earlier ones are those of smaller worlds (next test)."""
    assert_limits(drawn("mixed", intruders=intruders))


def test_an_intruder_does_not_depend_on_how_many_follow():
    few, many = fresh(200, intruders=3).state.aircraft, fresh(200, intruders=8).state.aircraft
    for name in ("path_m", "path_s", "path_points"):
        assert np.array_equal(few[name], many[name][:, :4])


def test_number_of_intruders_is_drawn():
    batch = fresh(2000, intruders=8, intruders_min=1)
    counts = np.bincount(batch.episode["intruders"], minlength=9)
    assert counts[0] == 0
    assert stats.chisquare(counts[1:]).pvalue > 1e-4


@pytest.mark.parametrize("planar", [True, False])
def test_about_two_fifths_collide_if_nobody_acts(planar):
    """By the exact interval of the share, at 95 %. The radio is left out: zero action does not listen."""
    batch = fresh(planar=planar, agent="gnss", intruder="gnss", estimator="ls", channel={"sensitivity_dbm": 0.0})
    done, actions = np.zeros(N, bool), np.zeros((N, 3))
    while not done.all():
        batch.step(actions, ~done)
        done |= batch.episode["terminated"] | batch.episode["truncated"]
    share = stats.binomtest(int(batch.episode["collision"].sum()), N).proportion_ci(0.95, method="exact")
    print(
        f"\nshare of {N} mixed encounters that collide under zero action, planar {planar}: {share.low} to {share.high}"
    )
    assert share.low > (0.36 if planar else 0.33) and share.high < 0.44


def test_from_behind_the_intruder_is_faster_and_starts_behind():
    d, batch = drawn("from-behind"), fresh(families="from-behind")
    assert np.all(d.speeds[1] > d.speeds[0])
    r = batch.state.aircraft["path_m"][:, 1, 0] - batch.state.aircraft["path_m"][:, 0, 0]
    assert np.mean(np.sum(r * batch.state.aircraft["along"][:, 0], axis=1) < 0.0) > 0.9


def test_the_own_turn_does_not_tell_when_the_closest_approach_is():
    """It is made at any time from 40 s before to 20 s after it, as far as the flight lasts as long before it."""
    batch = fresh(families="turning")
    agent, approach_s = batch.state.aircraft[:, 0], batch.episode["approach_s"]
    before_s, most_s = approach_s - agent["path_s"][:, 1], np.minimum(40.0, 0.6 * approach_s)
    share = (before_s + 20.0) / (most_s + 20.0)
    assert np.all((share >= -1e-9) & (share <= 1.0 + 1e-9))
    assert stats.kstest(share, stats.uniform(0.0, 1.0).cdf).statistic < 0.1
    assert len(np.unique(np.round(before_s / approach_s, 6))) > 0.99 * N  # no share of the flight is preferred


# -- registry ---------------------------------------------------------------------------------------------------------


def test_weights_are_shares():
    assert all(encounters.FAMILIES[name].weight == 0.0 for name in SCRIPTS)
    assert set(LAWS) - set(MIXED) == {*SEPARATING, "merging"}
    table = encounters.table(Encounter())
    assert table["weight"][-1] == 1.0
    weights = np.array([f.weight for f in MIXED.values()])
    np.testing.assert_allclose(np.diff(table["weight"], prepend=0.0), weights / weights.sum())


def test_mixed_draws_by_weight():
    counts = np.bincount(drawn("mixed").family, minlength=len(MIXED))
    weights = np.array([f.weight for f in MIXED.values()])
    assert stats.chisquare(counts, N * weights / weights.sum()).pvalue > 1e-4


@pytest.mark.parametrize("name", list(encounters.FAMILIES))
def test_every_family_is_reachable_by_name(name):
    family = encounters.FAMILIES[name]
    assert encounters.chosen(Encounter(families=name)) == [name]
    assert 0.0 <= family.conflict_share <= 1.0
    for low, high in (family.crossing_rad, family.turn_rad or (0.0, 0.0)):
        assert 0.0 <= low <= high <= np.pi + 1e-12
    assert family.summary
    assert not family.summary.endswith(".")
    assert np.all(fresh(20, families=name).episode["family"] == 0)


@pytest.mark.parametrize("name", list(SCRIPTS))
def test_scripts_are_laid_as_written(name):
    """In the axes of the agent's heading, which is drawn."""
    script, batch = SCRIPTS[name], fresh(200, families=name)
    agent, intruder = batch.state.aircraft[:, 0], batch.state.aircraft[:, 1]
    times = np.linspace(0.0, script.end_s, 7)
    (own, own_v), (other, _) = (path_at(aircraft, np.tile(times, (batch.n, 1))) for aircraft in (agent, intruder))
    np.testing.assert_allclose(np.linalg.norm(own_v, axis=2), script.own_mps, rtol=1e-12)
    heading = own_v[:, 0] / script.own_mps
    right = np.stack([heading[:, 1], -heading[:, 0], 0.0 * heading[:, 0]], axis=1)
    r = other - own
    along = script.start_m[0] + (script.velocity_mps[0] - script.own_mps) * times
    across = script.start_m[1] + script.velocity_mps[1] * times
    np.testing.assert_allclose(np.sum(r * heading[:, None], axis=2), np.tile(along, (batch.n, 1)), atol=1e-9)
    np.testing.assert_allclose(np.sum(r * right[:, None], axis=2), np.tile(across, (batch.n, 1)), atol=1e-9)
    np.testing.assert_allclose(r[..., 2], script.start_m[2], atol=1e-12)
    assert stats.kstest(np.arctan2(heading[:, 1], heading[:, 0]), stats.uniform(-np.pi, 2.0 * np.pi).cdf).pvalue > 1e-4


def test_several_families_and_unknown_ones():
    assert encounters.chosen(Encounter(families=("turning", "crossing"))) == ["crossing", "turning"]
    assert encounters.chosen(Encounter()) == list(MIXED)
    batch = fresh(2000, families=("turning", "crossing"))
    weights = np.array([encounters.FAMILIES[name].weight for name in ("crossing", "turning")])
    assert stats.chisquare(np.bincount(batch.episode["family"]), 2000 * weights / weights.sum()).pvalue > 1e-4
    with pytest.raises(ParamsError, match="did you mean 'crossing'"):
        encounters.chosen(Encounter(families="crosing"))


def test_impossible_limits_are_refused_with_a_sentence():
    """Slow aircraft that start far away cannot meet within five seconds."""
    with pytest.raises(ParamsError, match="no encounter of families"):
        fresh(1, time_to_approach_max_s=5.0)
