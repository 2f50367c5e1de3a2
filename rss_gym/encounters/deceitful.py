"""Deceitful: the intruder announces a turn and flies straight on; its radio and its position stay true."""

from rss_gym.encounters.family import Complication, Family, degrees

DECEITFUL = Family(
    summary="messages tell of a turn by 30-90 degrees, 8-20 s before the closest approach, that is not flown",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.42,
    complication=Complication(bend_s=(8.0, 20.0), announced_rad=degrees(30, 90)),
)
