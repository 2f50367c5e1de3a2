"""What every preset of the channel must keep."""

from __future__ import annotations

import json

import numpy as np

from rss_gym.params import CHANNELS, Params, load_channel
from rss_gym.testing.flights import check_rows_alone, ended, fly_on, fresh

COUNT = 50


def check_channel(name: str) -> None:
    """It says where its numbers are from, travels as JSON, and flies: ranges finite and positive, rows as alone."""
    assert CHANNELS[name].summary.strip(), f"channel {name!r} has no summary"
    channel = load_channel(name)
    assert load_channel(json.loads(json.dumps(channel.to_dict(), allow_nan=False))) == channel
    params = Params.of(channel=name)
    assert params.channels == (channel,)
    batch = fresh(params, COUNT)
    fly_on(batch)
    assert ended(batch).all(), f"channel {name!r}: a flight does not end"
    ranges_m = batch.state.links["range_m"][:, 0]
    assert np.isfinite(ranges_m).all() and (ranges_m > 0.0).all(), f"channel {name!r}: a range is not positive"
    check_rows_alone(params)
