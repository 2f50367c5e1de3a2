"""Head-on: the intruder comes nearly straight at the agent."""

from rss_gym.encounters.family import Family, degrees

HEAD_ON = Family(
    summary="opposite headings within 30 degrees", weight=0.15, crossing_rad=degrees(150, 180), conflict_share=0.42
)
