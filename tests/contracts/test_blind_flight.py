"""What does not listen flies the same whatever the radio says."""

import numpy as np
import pytest

from rss_gym import baselines
from rss_gym.core import SPLITS, Batch, decode
from rss_gym.params import Params

# Nothing of the radio is left: all deaf, positions by satellite, the worst estimator.
DEAF = {"agent": "gnss", "intruder": "gnss", "estimator": "ls", "channel": {"sensitivity_dbm": 0.0}}


def fly(spec, n, **keywords):
    """Episodes 0 of the seeds 0..n-1 of split `validation`: their records at the end."""
    policy = baselines.make(spec, Params.of(**keywords))
    batch, rows = Batch(policy.params, n), np.ones(n, bool)
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.apply_options({"split": "validation", "episode": 0}, rows)
    assert np.all(batch.split == SPLITS["validation"])
    batch.reset(rows)
    done, state = np.zeros(n, bool), None
    while not done.all():
        actions, state = policy.predict(batch.observations, state)
        batch.step(decode(actions, policy.params, n), ~done)
        done = batch.episode["terminated"] | batch.episode["truncated"]
    return batch.episode.copy()


@pytest.mark.parametrize(
    "spec", ["constant:along_m=10,right_m=15", "velocity", "stop", "back", "climb:up_m=6", "blind"]
)
def test_the_radio_changes_nothing_for_who_does_not_listen(spec):
    planar = not spec.startswith("climb")
    full, deaf = fly(spec, 300, planar=planar), fly(spec, 300, planar=planar, **DEAF)
    for column in ("collision", "snmac", "min_separation_m", "cost_m"):
        np.testing.assert_array_equal(full[column], deaf[column])
    assert full["cost_m"].min() > 0.0
