"""Parallel pass: opposite or equal headings on parallel lines that keep apart."""

from rss_gym.encounters.family import Family, degrees

PARALLEL_PASS = Family(
    summary="opposite headings on parallel lines 8-60 m apart",
    weight=0.075,
    crossing_rad=degrees(180, 180),
    conflict_share=0.0,
    offset_m=(8.0, 60.0),
)
