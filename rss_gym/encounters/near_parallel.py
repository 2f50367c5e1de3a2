"""Near-parallel: paths cross so flatly that a small error of position decides who passes ahead."""

from rss_gym.encounters.family import Family, degrees

NEAR_PARALLEL = Family(
    summary="paths cross within 10 degrees, one faster", weight=0.0, crossing_rad=degrees(0, 10), conflict_share=0.42
)
