"""Overtaking: the same direction at different speeds; either may be the faster one."""

from rss_gym.encounters.family import Family, degrees

OVERTAKING = Family(
    summary="same heading within 30 degrees, one faster", weight=0.1, crossing_rad=degrees(0, 30), conflict_share=0.42
)
