"""Merging: several intruders converge on one point of the agent's path and fly on together."""

from rss_gym.encounters.family import Complication, Family, degrees

MERGING = Family(
    summary="all intruders reach one point of the agent's path together and turn to one course",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.03,
    complication=Complication(merging=True),
)
