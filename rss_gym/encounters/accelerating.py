"""Accelerating: the intruder changes its speed after the exchange has begun."""

from rss_gym.encounters.family import Complication, Family, degrees

ACCELERATING = Family(
    summary="the intruder changes its speed by 1-2 m/s 4-12 s before the closest approach",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.42,
    complication=Complication(speed_change_mps=(1.0, 2.0)),
)
