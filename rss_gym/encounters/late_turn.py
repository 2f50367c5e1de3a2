"""Late turn: the intruder turns after the exchange has begun, so that what was true of it no longer is."""

from rss_gym.encounters.family import Complication, Family, degrees

LATE_TURN = Family(
    summary="the intruder alone turns 30-90 degrees 4-12 s before the closest approach",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.42,
    complication=Complication(turn_rad=degrees(30, 90)),
)
