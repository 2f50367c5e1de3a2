"""The safety zone (29)-(40), the coherence of the channel, and what correlated errors make of both."""

from rss_gym.safety.coherence import coherence_s, least_miss_probability, trials_max
from rss_gym.safety.correlated import CorrelatedZone, correlated_zone, miss_probability_correlated
from rss_gym.safety.zone import (
    STD_TO_80_PERCENT,
    error_probability,
    error_probability_normal,
    miss_probability,
    missed_detection,
    pair_radius_m,
    perfect_radius_m,
    radius_m,
    trials,
    violates,
    zone_radius_m,
)

__all__ = [
    "STD_TO_80_PERCENT",
    "CorrelatedZone",
    "coherence_s",
    "correlated_zone",
    "error_probability",
    "error_probability_normal",
    "least_miss_probability",
    "miss_probability",
    "miss_probability_correlated",
    "missed_detection",
    "pair_radius_m",
    "perfect_radius_m",
    "radius_m",
    "trials",
    "trials_max",
    "violates",
    "zone_radius_m",
]
