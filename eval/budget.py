"""What a stranger's world and policy may cost to fly: sizes that are known before a flight."""

from __future__ import annotations

from collections.abc import Iterable

from rss_gym import baselines
from rss_gym.highway.params import RoadParams
from rss_gym.params import Params, ParamsError

TICKS_MAX = 20_000  # of an encounter, times the intruders; the largest suite has 9,600
CHAIN_MAX = 2  # filters `cbf+` round a policy


def refuse_costly(params: Params, specs: Iterable[str] = ()) -> None:
    """Refuse a world whose encounters take far more work than those of any suite, and policies in deep chains.

    Raises
    ------
    ParamsError
    """
    if isinstance(params, RoadParams):
        if params.road.config:
            raise ParamsError("the world has a road of its own (road.config), whose cost is not known; it is not flown")
    else:
        longest_s = params.encounter.time_to_approach_max_s + params.clock.tail_max_s
        ticks = longest_s / params.clock.tick_s * params.encounter.intruders
        if ticks > TICKS_MAX:
            raise ParamsError(
                f"an encounter of this world takes up to {ticks:,.0f} ticks times intruders, which is too costly to "
                f"fly; it must be at most {TICKS_MAX:,}"
            )
    for spec in specs:
        filters = chain(spec)
        if filters > CHAIN_MAX:
            raise ParamsError(f"policy {spec[:60]!r} has {filters} filters; it must have at most {CHAIN_MAX}")


def chain(spec: str) -> int:
    """How many filters stand round a policy."""
    filters = 0
    while baselines.is_known(spec) and (base := baselines.parse(spec).base):
        spec, filters = base, filters + 1
    return filters
