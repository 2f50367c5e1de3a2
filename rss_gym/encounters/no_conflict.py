"""No conflict: the paths stay well apart; any manoeuvre is unnecessary."""

from rss_gym.encounters.family import Family, degrees

NO_CONFLICT = Family(
    summary="any crossing angle, 60-110 m apart at the closest approach",
    weight=0.075,
    crossing_rad=degrees(30, 180),
    conflict_share=0.0,
    offset_m=(60.0, 110.0),
)
