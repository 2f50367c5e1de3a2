"""From behind: a faster intruder catches up, so that backing off runs into it."""

from rss_gym.encounters.family import Family, degrees

FROM_BEHIND = Family(
    summary="a faster intruder comes from behind, its heading within 30 degrees",
    weight=0.1,
    crossing_rad=degrees(0, 30),
    conflict_share=0.42,
    faster=True,
)
