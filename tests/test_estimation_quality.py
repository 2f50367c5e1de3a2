"""The filter's stated std is honest at every distance, and conflicts are warned of in time."""

from itertools import pairwise

import numpy as np
import pytest

from rss_gym.core import Batch
from rss_gym.params import Params

N = 3000
BINS_M = [0, 5, 10, 20, 30, 45, 60, 80, 100, 120, 150]
RATIO_LIMIT = 1.7  # of rms(error / std), in every bin, on `paper`
LATE_M, LATE_SHARE = 60.0, 0.05  # a conflict first warned of below this true distance is late


def fly(**keywords):
    """Zero action over `N` mixed encounters.

    Returns true distance, estimated range and its std at every decision (NaN after a flight's end), each (n, steps),
    and the true distance at the first warning of the encounters that collide (0 if there was none).
    """
    batch = Batch(Params.of(**keywords), N)
    batch.seed(np.arange(N, dtype=np.uint64))
    batch.apply_options({"split": "validation"}, np.ones(N, bool))
    batch.reset(np.ones(N, bool))
    done, over, actions, frames = np.zeros(N, bool), np.zeros(N, bool), np.zeros((N, 3)), []
    while True:
        position, link = batch.state.aircraft["position_m"], batch.state.links[:, 0]
        d = np.linalg.norm(position[:, 1] - position[:, 0], axis=1)
        frames.append(np.where(over, np.nan, np.stack([d, link["range_m"], np.sqrt(link["p_dd"])])))
        if done.all():
            break
        over = done.copy()
        batch.step(actions, ~done)
        done |= batch.episode["terminated"] | batch.episode["truncated"]
    d, estimate, std = np.stack(frames, axis=2)
    warned_s, period_s = batch.episode["warned_s"], batch.params.clock.decision_s
    times = period_s * np.arange(d.shape[1])
    at_warning = [np.interp(warned_s[i], times, d[i]) if warned_s[i] >= 0.0 else 0.0 for i in range(N)]
    return d, estimate, std, np.array(at_warning)[batch.episode["collision"]]


def report(title, d, estimate, std, at_warning):
    """Print and return rms(error / std) per bin and the share of late warnings."""
    ratios = []
    print(f"\n{title}: {N} encounters\n{'true distance':>15} {'samples':>9} {'rms(error/std)':>15} {'|error| p50':>12}")
    for low, high in pairwise(BINS_M):
        inside = (d >= low) & (d < high)
        error = estimate[inside] - d[inside]
        ratios.append(float(np.sqrt(np.mean((error / std[inside]) ** 2))))
        print(f"{low:>7}-{high:<5} m {inside.sum():>9} {ratios[-1]:>15.2f} {np.median(abs(error)):>10.1f} m")
    late = float(np.mean(at_warning < LATE_M))
    print(
        f"conflicts {len(at_warning)}, first warned at a median of {np.median(at_warning):.0f} m, "
        f"below {LATE_M:g} m: {100 * late:.1f} %, never: {np.sum(at_warning == 0.0)}"
    )
    return ratios, late


@pytest.mark.slow
@pytest.mark.parametrize("planar", [True, False])
def test_paper(planar):
    ratios, late = report(f"paper, {'plane' if planar else 'space'}", *fly(channel="paper", planar=planar))
    assert max(ratios) < RATIO_LIMIT
    assert min(ratios) > 0.4  # nor so cautious that the std says nothing
    assert late <= LATE_SHARE


def test_quadcopter_is_printed():
    """A measured channel with slow, strong noise: no promise, but neither nonsense."""
    ratios, late = report("quadcopter, plane", *fly(channel="quadcopter"))
    assert max(ratios) < 3.0
    assert late < 0.3
