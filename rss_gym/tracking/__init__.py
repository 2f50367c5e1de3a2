"""Trackers (provisional)."""
import numpy as np

from rss_gym.tracking.record import TRACK

LATEST, FUSED, BEARINGS = 0, 1, 2
TRACKERS = {"latest": LATEST, "fused": FUSED, "bearings": BEARINGS}


def memories(params, n):
    return np.zeros((n, params.encounter.intruders, 4))


def model(params):
    return np.zeros(1, np.dtype([("decision_s", float)]))
