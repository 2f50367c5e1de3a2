"""Merging: several intruders converge on one point of the agent's path and fly on together."""

from rss_gym.encounters.family import Complication, Family, degrees

MERGING = Family(
    summary="intruders reach the agent's path one after another, within 30 m of it, and turn to one course",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.1,  # each
    offset_m=(5.0, 30.0),
    complication=Complication(merging=True),
)
