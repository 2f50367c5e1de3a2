"""Rows in and out of a block, field by field: what is loaded, what is stored, and that no lane touches another."""

import numba
import numpy as np
import pytest

from rss_gym import lanes
from rss_gym import state as arrays
from rss_gym.core import Batch
from rss_gym.params import Params

ROWS = 5  # of the batch; row i goes to lane i

# Fields whose lane has another name, or is made of more than one.
LINK_ELSEWHERE = {"wander", "jump", "jump_s"}
AIRCRAFT_NOT_STORED = {  # what a tick only reads
    "gust_mps", "gnss_error_m", "velocity_error_mps", "barometer_error_m", "datum_error_m", "hover_until_s", "along",
    "planned_mps",
}  # fmt: skip

load_, store_ = lanes.load, lanes.store


@numba.njit
def load(state, count):
    """`lanes.load` of every row; such functions have no entry from Python."""
    state.block[0].rows = count
    for r in range(count):
        state.block[0].row[r] = r
        load_(state, r)


@numba.njit
def store(state, count):
    """`lanes.store` of every row."""
    for r in range(count):
        store_(state, r)


def scrambled(**keywords):
    """A batch whose records are all different numbers; counts, flags and paths stay those of its encounters."""
    batch = Batch(Params.of(intruders=2, families="turning", **keywords), ROWS)
    batch.reset(np.ones(ROWS, bool))
    random = np.random.default_rng(0)
    state = batch.state
    for array in (state.episode, state.aircraft, state.links, state.contacts):
        for name in array.dtype.names:
            if array[name].dtype.kind == "f" and name not in ("path_m", "path_s"):
                array[name] = random.normal(size=array[name].shape)
    return batch


def lane_of(array, name, r):
    """A lane of a field, as the row's record has it."""
    return array[name][..., r]


@pytest.mark.parametrize("keywords", [{}, {"agent": "gnss"}, {"planar": False}], ids=str)
def test_a_lane_holds_every_field_of_its_row(keywords):
    batch = scrambled(**keywords)
    state = batch.state
    load(state, ROWS)
    for r in range(ROWS):
        e = state.episode[r]
        for name in ("tick", "deviation_m", "deviation_max_m", "flown_m"):
            assert lane_of(state.block[0], name, r) == e[name], name
        for name in arrays.CHANNEL.names:
            if name in arrays.BLOCK.names:
                assert lane_of(state.block[0], name, r) == state.channels[e["channel"]][name], name
        for a in range(3):
            lane, aircraft = state.aircraft_lanes[a], state.aircraft[r, a]
            for name in set(arrays.AIRCRAFT.names) & set(arrays.AIRCRAFT_LANES.names) - {"leg_m"}:
                np.testing.assert_array_equal(lane_of(lane, name, r), aircraft[name], err_msg=name)
            np.testing.assert_array_equal(lane_of(lane, "leg_m", r), aircraft["path_m"][aircraft["leg"]])
            assert lane_of(lane, "leg_s", r) == aircraft["path_s"][aircraft["leg"]]
        for k in range(2):
            lane, contact = state.contact_lanes[k], state.contacts[r, k]
            for name in ("position_m", "velocity_mps", "std_m"):
                np.testing.assert_array_equal(lane_of(lane, name, r), contact[name], err_msg=name)
        now_s = e["tick"] * batch.params.clock.tick_s
        for n in state.used:
            lane, link = state.link_lanes[n], state.links[r, n]
            for name in set(arrays.LINK.names) & set(arrays.LINK_LANES.names) - LINK_ELSEWHERE:
                assert lane_of(lane, name, r) == link[name], name
            jump = link["jump"] if now_s >= link["jump_s"] else 0.0
            assert lane_of(lane, "wander", r) == link["wander"] + jump


def test_what_a_tick_writes_is_stored_in_its_row_alone():
    batch = scrambled()
    state = batch.state
    load(state, ROWS)
    before = state.aircraft.copy(), state.links.copy(), state.episode.copy()
    random = np.random.default_rng(1)
    for array in (state.aircraft_lanes, state.link_lanes):
        for name in array.dtype.names:
            array[name] = random.normal(size=array[name].shape)
    for name in ("deviation_m", "deviation_max_m", "flown_m"):
        state.block[name] = random.normal(size=state.block[name].shape)
    store(state, ROWS - 1)
    for r in range(ROWS):
        is_stored = r < ROWS - 1
        for a in range(3):
            for name in arrays.AIRCRAFT.names:
                is_lane = name in arrays.AIRCRAFT_LANES.names and name not in AIRCRAFT_NOT_STORED
                wanted = lane_of(state.aircraft_lanes[a], name, r) if is_lane and is_stored else before[0][r, a][name]
                np.testing.assert_array_equal(state.aircraft[r, a][name], wanted, err_msg=name)
        for n in range(state.links.shape[1]):
            for name in arrays.LINK.names:
                is_lane = name in arrays.LINK_LANES.names and name not in LINK_ELSEWHERE and n in state.used
                wanted = lane_of(state.link_lanes[n], name, r) if is_lane and is_stored else before[1][r, n][name]
                assert state.links[r, n][name] == wanted, name
        for name in ("deviation_m", "deviation_max_m", "flown_m"):
            wanted = lane_of(state.block[0], name, r) if is_stored else before[2][r][name]
            assert state.episode[r][name] == wanted, name
