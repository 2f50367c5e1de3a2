"""Trackers on what the simulator senses: consistent on a quick, a medium and a slow radio."""

import numpy as np
import pytest
import sensed_flights as sensing

from rss_gym.core import Batch
from rss_gym.params import Params
from rss_gym.sensed import OTHER, OWN
from rss_gym.tracking import TRACK, fused, latest, memory_columns, model

ROWS = 200
BINS_M = ((0.0, 20.0), (20.0, 40.0), (40.0, 60.0), (60.0, 90.0), (90.0, 120.0))
QUICK = {"white_variance_db2": 0.1, "coloured_variance_db2": 6.4, "coloured_tc_s": 0.15, "path_loss_wander": 0.0}
MEDIUM = {"white_variance_db2": 4.0, "coloured_variance_db2": 4.0, "coloured_tc_s": 2.0, "path_loss_wander": 0.05}
SLOW = {"path_loss_factor": 3.3, "white_variance_db2": 1.6, "coloured_variance_db2": 20.9, "coloured_tc_s": 6.7}


def sensed(batch):
    """OWN and OTHER of the first intruder in every row, of the records that sensing copies."""
    own, other = np.zeros(batch.n, OWN), np.zeros(batch.n, OTHER)
    agent, contact, link = batch.state.aircraft[:, 0], batch.state.contacts[:, 0], batch.state.links[:, 0]
    channel = batch.params.channels[0]
    own["position_m"], own["velocity_mps"] = agent["solution_m"], agent["solution_mps"]
    own["std_m"] = agent["solution_std_m"]
    other["range_m"], other["range_std_m"] = link["range_m"], np.sqrt(link["p_dd"])
    for name in ("warning", "valid", "age_s", "position_m", "velocity_mps", "std_m"):
        other[name] = contact[name]
    other["path_loss_factor"], other["white_std_db"] = channel.path_loss_factor, np.sqrt(channel.white_variance_db2)
    other["coloured_std_db"], other["coloured_tc_s"] = np.sqrt(channel.coloured_variance_db2), channel.coloured_tc_s
    return own, other


def flown(params, modules):
    """True relative positions, and of every tracker its tracks, of all decisions under way."""
    batch, constants = Batch(params, ROWS), model(params)[0]
    batch.seed(np.arange(ROWS, dtype=np.uint64) + np.uint64(8_000_000))
    batch.reset(np.ones(ROWS, bool))
    tracks = {name: np.zeros(ROWS, TRACK) for name in modules}
    memory = {name: np.zeros((ROWS, memory_columns(name))) for name in modules}
    truth, out, live = [], {name: [] for name in modules}, np.ones(ROWS, bool)
    while live.any():
        own, other = sensed(batch)
        for name, module in modules.items():
            for row in np.flatnonzero(live):
                module.advance(own[row], other[row], memory[name][row], tracks[name][row], constants)
            out[name].append(tracks[name][live])
        aircraft = batch.state.aircraft["position_m"]
        truth.append((aircraft[:, 1] - aircraft[:, 0])[live, :2])
        batch.step(np.zeros((ROWS, 3)), live)
        live &= ~(batch.episode["terminated"] | batch.episode["truncated"])
    truth = np.concatenate(truth)
    return truth, {name: np.concatenate(tracks) for name, tracks in out.items()}


@pytest.mark.slow
@pytest.mark.parametrize("channel", [QUICK, MEDIUM, SLOW], ids=["quick", "medium", "slow"])
@pytest.mark.parametrize("agent", ["rss", "gnss"])
def test_errors_are_as_stated_at_every_distance(channel, agent):
    params = Params.of(agent=agent, intruder="rss", node_square_m=300.0, channel=channel)
    truth, tracks = flown(params, {"fused": fused, "latest": latest})
    heard = tracks["fused"]["valid"]
    truth = truth[heard]
    d = np.linalg.norm(truth, axis=-1)
    along, across, error = sensing.standardised(tracks["fused"][heard], truth)
    for low, high in BINS_M:
        inside = (d >= low) & (d < high)
        assert inside.sum() > 300
        assert 0.4 < sensing.rms(along[inside]) < 1.5
        assert 0.4 < sensing.rms(across[inside]) < 1.5
    _, _, held = sensing.standardised(tracks["latest"][heard], truth)
    near = d < 20.0
    assert sensing.rms(error[near]) < 0.65 * sensing.rms(held[near])
