"""Turning: both aircraft turn at a way point, the intruder before the closest approach."""

from rss_gym.encounters.family import Family, degrees

TURNING = Family(
    summary="both turn 30-90 degrees: the intruder 6-20 s before the closest approach, the agent at any time",
    weight=0.25,
    crossing_rad=degrees(0, 180),
    conflict_share=0.42,
    turn_rad=degrees(30, 90),
)
