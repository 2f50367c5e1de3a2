"""The numbers of the sensor on the road: the world's `Params`, with defaults that differ where a road does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from rss_gym.params import MAX_INTRUDERS, Group, Navigation, Params, ParamsError, Ranging, Reward, Zone, suggestion

# |v| of (40) is the relative speed of the fastest and the slowest of highway-env's vehicles, 30 and 20 m/s. With the
# world's n_d = 8 the zone would be 120 m and hold everybody on the road for good; with n_d = 3, which bounds a missed
# conflict by 0.2^3 = 0.008, it is (4 / 0.8 + 10 * 1) * 3 = 45 m.
ZONE = Zone(speed_relative_max_mps=10.0, collision_probability=1e-2)
RANGING = Ranging(prior_range_m=80.0)  # of a vehicle first heard, between the next one and the end of radio range
NAVIGATION = Navigation(agent="gnss", intruder="gnss")
NAVIGATED = ("gnss_m", "gnss_tc_s", "velocity_mps", "velocity_tc_s")  # what a road has of `Navigation`
PRICES = ("deviation_price", "snmac_price_m", "collision_price_m")  # what a road has of `Reward`

G = TypeVar("G", bound=Group)


def settings(
    tick_s: float,
    decision_s: float,
    vehicles: int = 6,
    channel: Any = "paper",
    information: str = "positions",
    estimator: str = "ekf-coloured",
    zone: Zone | Mapping[str, Any] | None = None,
    ranging: Mapping[str, Any] | None = None,
    navigation: Mapping[str, Any] | None = None,
) -> Params:
    """The parameters of the sensor.

    Parameters
    ----------
    tick_s, decision_s : float
        Periods of the simulation and of the policy.
    vehicles : int
        How many of the nearest vehicles are observed, 1 to 8.
    channel : str, path, dict, Channel or a list of these
        As in the world; one is drawn an episode.
    information, estimator : str
        As in the world.
    zone, ranging, navigation : dict, optional
        Fields of `rss_gym.params.Zone`, `Ranging` and `Navigation` that differ from the road's defaults.

    Raises
    ------
    ParamsError
        For an unknown name, with the nearest known one, or a value out of range.
    """
    if isinstance(vehicles, bool) or not isinstance(vehicles, int) or not 1 <= vehicles <= MAX_INTRUDERS:
        raise ParamsError(f"vehicles must be a whole number in [1, {MAX_INTRUDERS}], got {vehicles!r}")
    if navigation is not None:
        of_a_road("navigation", navigation, NAVIGATED)
    return Params.of(
        {
            "clock": {"tick_s": tick_s, "decision_s": decision_s},
            "zone": (zone if isinstance(zone, Zone) else changed("zone", ZONE, zone)).to_dict(),
            "ranging": changed("ranging", RANGING, ranging).to_dict(),
            "navigation": changed("navigation", NAVIGATION, navigation).to_dict(),
        },
        intruders=vehicles,
        channel=channel,
        estimator=estimator,
        agent="gnss",
        intruder="gnss",
        information=information,
    )


def prices(reward: Mapping[str, Any] | None) -> Reward:
    """The prices of a road, some changed.

    Raises
    ------
    ParamsError
        For a name that is not one of `PRICES`, or a value out of range.
    """
    of_a_road("reward", {} if reward is None else reward, PRICES)
    return changed("reward", Reward(), reward)


def of_a_road(name: str, given: Mapping[str, Any], known: tuple[str, ...]) -> None:
    """Refuse the parameters of a group that a road does not have."""
    for parameter in mapping(name, given):
        if parameter not in known:
            raise ParamsError(f"{name} has no parameter {parameter!r} on a road{suggestion(str(parameter), known)}")


def changed(name: str, base: G, given: Mapping[str, Any] | None) -> G:
    """A group with some fields changed.

    Raises
    ------
    ParamsError
        Naming the group too.
    """
    try:
        return base.replace(**mapping(name, {} if given is None else given))
    except ParamsError as error:
        raise ParamsError(f"{name}: {error}") from error


def mapping(name: str, given: Any) -> Mapping[str, Any]:
    """`given`, found to be a dict."""
    if not isinstance(given, Mapping):
        raise ParamsError(f"{name} must be a dict of parameters, got {given!r}")
    return given
