"""The columns of scores: what the terminal, notebooks, pages and documents call each metric, and how they show it."""

from __future__ import annotations

from rss_gym.domain import ROAD as ROADS
from rss_gym.domain import domain_of
from rss_gym.pages.table import Column
from rss_gym.params import Params

AIR: dict[str, Column] = {
    "cost_m": Column("cost", "m", ".2f"),
    "collision_rate": Column("collisions", form=".2e"),
    "snmac_rate": Column("sNMACs", form=".2e"),
    "path_deviation_mean_m": Column("mean deviation", "m", ".2f"),
    "unnecessary_manoeuvre_rate": Column("unnecessary manoeuvres", form=".3f", interval=False),
    "zone_severity": Column("zone severity", form=".3f", interval=False),
    "path_regained_rate": Column("path regained", form=".3f", interval=False),
    "faults": Column("faults", form=",.0f", interval=False),
}
ROAD: dict[str, Column] = {
    "cost_m": Column("cost", "m", ".1f"),
    "collision_rate": Column("collisions", form=".3f"),
    "snmac_rate": Column("near misses", form=".3f"),
    "path_deviation_mean_m": Column("mean deviation", "m", ".1f"),
    "lane_deviation_m": Column("off the planned lane", "m", ".2f"),
    "speed_deviation_mps": Column("off the planned speed", "m/s", ".2f"),
    "unnecessary_manoeuvre_rate": AIR["unnecessary_manoeuvre_rate"],
    "zone_violation_rate": Column("zone violations", form=".3f", interval=False),
    "path_regained_rate": AIR["path_regained_rate"],
    "faults": AIR["faults"],
}
MORE = Column("more than the first", "m", "+.2f")
"""The paired difference of the cost from that of the first."""
REGRET = Column("more than `qmdp`", "m", "+.2f", interval=False)
"""That from the cost of the value table at its cheapest setting: the regret against it."""
ROAD_NOTE = (
    "On a road the deviation is the distance from where the planned lane and speed would have led. A near miss, called "
    "sNMAC as in the air: at a tick a vehicle would touch the agent within 1.5 s if both went straight on. The zone of "
    "a pair is (40) at the true closing speed; it is violated by a vehicle on the agent's own lane only."
)


def columns_of(params: Params) -> dict[str, Column]:
    """Metric -> column of the table that is read first, in a world."""
    return ROAD if domain_of(params) is ROADS else AIR
