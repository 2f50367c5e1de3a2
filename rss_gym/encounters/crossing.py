"""Crossing: the intruder comes from the side, on a straight path."""

from rss_gym.encounters.family import Family, degrees

CROSSING = Family(
    summary="paths cross at 30-150 degrees", weight=0.35, crossing_rad=degrees(30, 150), conflict_share=0.42
)
