"""Outage: the link is silent for seconds when it is needed."""

from rss_gym.encounters.family import Complication, Family, degrees

OUTAGE = Family(
    summary="neither RSS nor messages for 5-15 s, from within 5 s of the entry into the zone",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.42,
    complication=Complication(outage_s=(5.0, 15.0)),
)
