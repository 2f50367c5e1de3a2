"""How scores on a road are shown, where a road differs from the air."""

COLUMNS: dict[str, tuple[str, float, str] | tuple[str, float, str, bool]] = {
    "cost_m": ("cost m", 1.0, ".1f"),
    "collision_rate": ("collision rate", 1.0, ".3f"),
    "snmac_rate": ("near misses", 1.0, ".3f"),
    "path_deviation_mean_m": ("deviation m", 1.0, ".1f"),
    "lane_deviation_m": ("off the lane m", 1.0, ".2f", False),
    "speed_deviation_mps": ("off the speed m/s", 1.0, ".2f", False),
    "faults": ("faults", 1.0, ",.0f", False),
}
MAIN = (
    "cost_m",
    "collision_rate",
    "snmac_rate",
    "path_deviation_mean_m",
    "unnecessary_manoeuvre_rate",
    "zone_violation_rate",
    "path_regained_rate",
    "faults",
)
NOTE = (
    "On a road the deviation is the distance from where the planned lane and speed would have led. A near miss, called "
    "sNMAC as in the air: at a tick a vehicle would touch the agent within 1.5 s if both went straight on. The zone of "
    "a pair is (40) at the true closing speed; it is violated by a vehicle on the agent's own lane only."
)
