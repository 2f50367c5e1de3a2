"""What intruders send, when it arrives, and what it is made of."""

import numpy as np
import pytest

from rss_gym.core import Batch
from rss_gym.params import Params

N = 64


def fresh(n=N, **keywords):
    batch = Batch(Params.of(decision_s=0.1, **keywords), n)  # a decision is one tick, so every tick is seen
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.reset(np.ones(n, bool))
    return batch


def flight(batch, ticks=500):
    """Fly with no action; yields the rows flying, after each tick."""
    ended = np.zeros(batch.n, bool)
    for _ in range(ticks):
        batch.step(np.zeros((batch.n, 3)), ~ended)
        ended |= batch.episode["terminated"] | batch.episode["truncated"]
        if ended.all():
            return
        yield ~ended


def own_statement(batch):
    """What intruder 0 of each row knows of itself now: position, velocity, accuracy."""
    intruder = batch.state.aircraft[:, 1]
    return intruder["solution_m"].copy(), intruder["solution_mps"].copy(), intruder["solution_std_m"].copy()


@pytest.mark.parametrize("latency_s", [0.0, 0.1, 0.7, 3.0])
def test_the_held_message_was_sent_a_latency_ago(latency_s):
    """GNSS: no fix moves a solution between the message and the end of the decision."""
    batch = fresh(intruder="gnss", message_latency_s=latency_s, families="crossing")
    late, past, arrivals = round(latency_s / 0.1), [own_statement(batch)], 0
    contact = batch.state.contacts[:, 0]
    for flying in flight(batch):
        past.append(own_statement(batch))
        new = flying & contact["valid"] & np.isclose(contact["age_s"], latency_s, atol=0.01)
        assert (contact["age_s"][flying & contact["valid"]] >= latency_s - 1e-9).all()
        if len(past) <= late + 1:
            continue
        position, velocity, std = past[-1 - late]
        np.testing.assert_array_equal(contact["position_m"][new], position[new])
        np.testing.assert_array_equal(contact["velocity_mps"][new], velocity[new])
        np.testing.assert_array_equal(contact["std_m"][new], std[new])
        arrivals += int(new.sum())
    assert arrivals > 50 * N


def test_messages_come_on_every_tick_while_the_warning_is_open():
    batch = fresh()
    contact = batch.state.contacts[:, 0]
    for flying in flight(batch):
        open_ = flying & contact["warning"]
        assert contact["valid"][open_].all()
        assert (contact["age_s"][open_] == 0.0).all()
        assert (contact["age_s"][flying & contact["valid"] & ~contact["warning"]] > 0.0).all()


def test_the_age_is_the_time_since_it_was_sent():
    """In the observation too, after the warning has closed."""
    batch = fresh(message_latency_s=0.5)
    contact, sent = batch.state.contacts[:, 0], np.full(N, np.nan)
    grown = 0
    for n, flying in enumerate(flight(batch, 900), start=1):
        new = flying & contact["valid"] & (contact["age_s"] < 0.55)
        sent[new] = n - 5
        known = flying & contact["valid"] & ~np.isnan(sent)
        np.testing.assert_allclose(contact["age_s"][known], 0.1 * (n - sent[known]), atol=1e-9)
        np.testing.assert_array_equal(batch.seen.others["age_s"][known, 0], contact["age_s"][known])
        grown += int((contact["age_s"][known] > 3.0).sum())
    assert grown > 100


@pytest.mark.parametrize("loss", [0.1, 0.5, 0.9])
def test_the_share_that_is_lost(loss):
    batch = fresh(256, message_loss=loss)
    contact, sent, heard = batch.state.contacts[:, 0], 0, 0
    for flying in flight(batch):
        open_ = flying & contact["warning"]
        sent += int(open_.sum())
        heard += int((contact["age_s"][open_ & contact["valid"]] == 0.0).sum())
    share = 1.0 - heard / sent
    assert abs(share - loss) < 4.5 * np.sqrt(loss * (1.0 - loss) / sent)


@pytest.mark.parametrize("information", ["positions", "ranges"])
def test_nobody_hears_anything_when_all_are_lost(information):
    batch = fresh(message_loss=1.0, information=information)
    for _ in flight(batch):
        assert not batch.state.contacts["valid"].any()
        assert not batch.state.tracks["valid"].any()
    assert batch.state.contacts["warning"].any()


def test_loss_is_the_same_for_every_policy():
    """Which messages are lost is a function of the episode and the tick alone."""
    still, busy = fresh(message_loss=0.5), fresh(message_loss=0.5)
    ended, generator, seen = np.zeros(N, bool), np.random.default_rng(0), 0
    for _ in range(300):
        still.step(np.zeros((N, 3)), ~ended)
        busy.step(generator.uniform(-1, 1, (N, 3)), ~ended)
        for batch in (still, busy):
            ended = ended | batch.episode["terminated"] | batch.episode["truncated"]
        one, two = still.state.contacts[:, 0], busy.state.contacts[:, 0]
        both = ~ended & one["warning"] & two["warning"] & one["valid"] & two["valid"]
        assert np.array_equal(one["age_s"][both] == 0.0, two["age_s"][both] == 0.0)
        seen += int(both.sum())
    assert seen > 1000


@pytest.mark.parametrize("announce_s", [0.0, 2.0, 5.0, 20.0])
@pytest.mark.parametrize("localisation", ["gnss", "rss"])
def test_the_way_point_of_a_straight_intruder(announce_s, localisation):
    """Its position, and `announce_s` times the planned velocity plus the sender's own error of velocity."""
    batch = fresh(families="crossing", intruder=localisation, announce_s=announce_s, planar=False)
    contact, intruder, count = batch.state.contacts[:, 0], batch.state.aircraft[:, 1], 0
    for flying in flight(batch, 200):
        new = flying & contact["valid"] & (contact["age_s"] == 0.0)
        ahead = contact["way_point_m"] - contact["position_m"]
        wanted = announce_s * (intruder["planned_mps"] + intruder["velocity_error_mps"])
        np.testing.assert_allclose(ahead[new], wanted[new], atol=1e-9)
        stated = contact["velocity_mps"] - intruder["velocity_mps"] - intruder["gust_mps"]
        np.testing.assert_allclose(stated[new], intruder["velocity_error_mps"][new], atol=1e-12)
        count += int(new.sum())
    assert count > 1000


def test_the_way_point_follows_the_plan_round_a_turn():
    """Where the path is `announce_s` later, minus where it is now, by NumPy's interpolation."""
    batch = fresh(families="late-turn", intruder="gnss", announce_s=6.0, velocity_mps=0.0)
    contact, intruder, bent = batch.state.contacts[:, 0], batch.state.aircraft[:, 1], 0
    for n, flying in enumerate(flight(batch, 700), start=1):
        for i in np.flatnonzero(flying & contact["valid"] & (contact["age_s"] == 0.0)):
            points = intruder["path_points"][i]
            due, path = intruder["path_s"][i, :points], intruder["path_m"][i, :points]
            if 0.1 * n + 6.0 > due[-1]:
                continue
            now, later = (np.array([np.interp(t, due, path[:, a]) for a in range(3)]) for t in (0.1 * n, 0.1 * n + 6.0))
            np.testing.assert_allclose(contact["way_point_m"][i] - contact["position_m"][i], later - now, atol=1e-8)
            bent += int(0.1 * n < due[1] < 0.1 * n + 6.0)
    assert bent > 500


@pytest.mark.parametrize("information", ["positions", "ranges"])
def test_nothing_heard_depends_on_the_end_of_the_flight(information):
    """The same encounters with other tails: messages, tracks and observations are equal, bit for bit."""
    keywords = {"families": "turning", "information": information, "intruders": 2}
    short, long = (fresh(tail_min_s=t, tail_max_s=t, **keywords) for t in (1.0, 200.0))
    # A draw may be refused for what happens in the longer flight; then it is another encounter.
    paths = [batch.state.aircraft["path_m"].reshape(N, -1) for batch in (short, long)]
    alike = (paths[0] == paths[1]).all(axis=1)
    assert alike.sum() > N // 4 and (short.episode["ticks"] < long.episode["ticks"])[alike].all()
    seen = 0
    for _ in range(1500):
        ended = short.episode["terminated"] | short.episode["truncated"]
        if ended.all():
            break
        for batch in (short, long):
            batch.step(np.full((N, 3), 0.05), ~ended)
        rows = alike & ~ended & ~short.episode["terminated"] & ~short.episode["truncated"]
        assert short.observations[rows].tobytes() == long.observations[rows].tobytes()
        assert short.state.contacts[rows].tobytes() == long.state.contacts[rows].tobytes()
        seen += int(rows.sum())
    assert ended.all() and seen > 100 * alike.sum()


def test_paths_go_on_beyond_their_last_way_point():
    """Announced way points too: no end is told, however far ahead they lie."""
    batch = fresh(
        families="crossing", intruder="gnss", velocity_mps=0.0, announce_s=60.0, tail_min_s=100.0, tail_max_s=100.0
    )
    contact, intruder, beyond = batch.state.contacts[:, 0], batch.state.aircraft[:, 1], 0
    for n, flying in enumerate(flight(batch, 1500), start=1):
        new = flying & contact["valid"] & (contact["age_s"] == 0.0)
        ahead = contact["way_point_m"] - contact["position_m"]
        np.testing.assert_allclose(ahead[new], 60.0 * intruder["planned_mps"][new], atol=1e-8)
        last_s = intruder["path_s"][np.arange(N), intruder["path_points"] - 1]
        beyond += int((new & (0.1 * n + 60.0 > last_s)).sum())
    assert beyond > 1000
