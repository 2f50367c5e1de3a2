"""What every family of encounters must keep."""

from __future__ import annotations

import json

import numpy as np

from rss_gym import encounters
from rss_gym.params import Params
from rss_gym.testing.flights import check_rows_alone, ended, fly_on, fresh

COUNT = 200


def check_family(name: str, several: int = 3) -> None:
    """It can be drawn, alone and with `several` intruders; its flights are finite and end; a row equals the row alone.

    Its definition travels as JSON, so that the hash of a suite covers it.
    """
    family = encounters.FAMILIES[name]
    assert family.summary.strip(), f"family {name!r} has no summary"
    assert json.loads(json.dumps(family.definition, allow_nan=False)), f"family {name!r} has no definition"
    for planar in (True, False):
        for intruders in (1,) if family.script is not None else (1, several):
            params = Params.of(families=name, planar=planar, intruders=intruders)
            batch = fresh(params, COUNT)
            assert (batch.episode["family"] == 0).all(), f"family {name!r}: another one was drawn"
            fly_on(batch)
            assert ended(batch).all(), f"family {name!r}: a flight does not end"
            for field in ("position_m", "velocity_mps", "solution_m"):
                assert np.isfinite(batch.state.aircraft[field]).all(), f"family {name!r}: {field} is not finite"
    check_rows_alone(Params.of(families=name))
