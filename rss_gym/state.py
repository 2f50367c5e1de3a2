"""The world's state as NumPy record arrays, one row per environment, and the parameters as one record for the kernels.

Every array of `State` has the batch as its first axis. Columns: aircraft 0 is the agent, 1..K the intruders in ID
order (lowest ID first); link k < K ranges agent and intruder k, link K + 4 a + j ranges aircraft a and reference node
j; contact k is what the agent has heard of intruder k.
"""

from typing import Any, Final, NamedTuple

import numpy as np

from rss_gym import streams, tracking
from rss_gym.params import Params
from rss_gym.ranging import ESTIMATORS
from rss_gym.streams import MAX_INTRUDERS, NODES

MAX_WAY_POINTS: Final = 8
ROWS: Final = 16  # of a block

# Codes of the choices in `params`.
ORACLE, POSITIONS, RANGES = 0, 1, 2
INFORMATION = {"oracle": ORACLE, "positions": POSITIONS, "ranges": RANGES}
GNSS, RSS, DEAD_RECKONING = 0, 1, 2
LOCALISATIONS = {"gnss": GNSS, "rss": RSS, "dead-reckoning": DEAD_RECKONING}

f8, i8, u8, b1 = np.float64, np.int64, np.uint64, np.bool_

EPISODE = np.dtype(
    [
        ("seed", u8),
        ("number", u8),
        ("split", i8),
        ("key", u8),
        ("channel", i8),  # index into State.channels
        ("family", i8),
        ("intruders", i8),  # present; the other rows are absent
        ("tick", i8),
        ("ticks", i8),  # length of the flight
        ("approach_s", f8),  # time of the first intruder's planned closest approach
        ("min_separation_m", f8),
        ("closest_s", f8),  # time of the tick in which it was least
        ("collision", b1),
        ("snmac", b1),
        ("zone", b1),
        ("terminated", b1),
        ("truncated", b1),
        ("deviation_m", f8),  # |u - u^d|, mean over the last decision
        ("deviation_max_m", f8),
        ("deviation_sum_m", f8),  # |u - u^d|, summed over the ticks flown
        ("proximity_sum", f8),  # squared closeness within `comfort_m`, likewise
        ("severity_sum", f8),  # depth inside the zone as a share of its radius, likewise
        ("flown_m", f8),  # length of the path flown
        ("warned_s", f8),  # time of the first warning, -1 before it
        ("false_alerts", i8),  # warnings that opened at a true separation above the zone radius
        ("missed", i8),  # longest run of ticks inside the zone with an estimated range outside it
        # The cost of the encounter so far, the mean deviation in it, and the terms of the last decision's reward
        ("cost_m", f8),
        ("deviation_mean_m", f8),
        ("zone_severity", f8),
        ("cost_deviation_m", f8),
        ("cost_snmac_m", f8),
        ("cost_proximity_m", f8),
        ("potential_m", f8),  # of the shaping
        ("reward_deviation", f8),
        ("reward_snmac", f8),
        ("reward_collision", f8),
        ("reward_proximity", f8),
        ("reward_shaping", f8),
    ]
)

AIRCRAFT = np.dtype(
    [
        ("position_m", f8, 3),
        ("velocity_mps", f8, 3),
        ("gust_mps", f8, 3),
        ("way_point_m", f8, 3),  # commanded
        # The predefined trajectory: way points, the time each is due, the leg being flown
        ("path_m", f8, (MAX_WAY_POINTS, 3)),
        ("path_s", f8, MAX_WAY_POINTS),
        ("path_points", i8),
        ("family", i8),  # index into State.families
        ("leg", i8),
        ("held_s", f8),  # time spent in a hover
        ("hover_until_s", f8),
        ("planned_m", f8, 3),  # u^d now
        ("planned_mps", f8, 3),
        ("along", f8, 3),  # unit vector of the current leg, horizontal
        # Errors of the navigation solution, and the solution
        ("gnss_error_m", f8, 3),
        ("velocity_error_mps", f8, 3),
        ("drift_m", f8, 3),
        ("barometer_error_m", f8),
        ("datum_error_m", f8),
        ("solution_m", f8, 3),
        ("solution_mps", f8, 3),
        ("solution_std_m", f8),
    ]
)

LINK = np.dtype(
    [
        ("coloured_db", f8),  # true coloured noise
        ("wander", f8),  # true path loss factor minus the channel's, before `jump`
        ("jump", f8),  # what the path loss factor jumps by at `jump_s`
        ("jump_s", f8),
        ("range_m", f8),  # the filter's state and covariance
        ("coloured_hat_db", f8),
        ("p_dd", f8),
        ("p_dp", f8),
        ("p_pp", f8),
        ("rate_mps", f8),
    ]
)

CONTACT = np.dtype(
    [
        ("radius_m", f8),  # S_ij in force
        ("warning", b1),
        ("clear_s", f8),  # time since the range was last below the closing threshold
        ("consecutive_warnings", i8),  # consecutive ticks with (29)
        ("hovered", b1),
        ("silent_s", f8),  # the link is silent from here
        ("silent_until_s", f8),
        ("false_turn", f8, 2),  # cosine and sine of what messages are turned by, from the sender's first way point on
        ("missed", i8),  # consecutive ticks inside the zone with an estimated range outside it
        # The held message: the sender's own solution
        ("valid", b1),
        ("age_s", f8),
        ("position_m", f8, 3),
        ("velocity_mps", f8, 3),
        ("way_point_m", f8, 3),
        ("std_m", f8),
    ]
)


def _lanes(names: str, *shape: int) -> list[Any]:
    return [(name, f8, (*shape, ROWS)) for name in names.split()]


# A message on its way: what the sender stated of itself, in its own solution.
MESSAGE = np.dtype(
    [
        ("sent", b1),
        ("position_m", f8, 3),
        ("velocity_mps", f8, 3),
        ("way_point_m", f8, 3),
        ("std_m", f8),
    ]
)

# A block is working memory: up to `ROWS` rows that fly a decision side by side, each on a lane. The lane is the last
# axis of every field, so that the compiler makes vector instructions of a loop over lanes. A pass writes one of these
# records and reads others, so that no loop needs to know whether two of its arrays overlap. Sixteen lanes fly 2.2 times
# as many decisions as one: 368,000 a CPU second against 171,000 (1,024 rows of the default world, two shared cores).
BLOCK = np.dtype(
    [
        ("rows", i8),  # in use
        ("row", i8, ROWS),  # their numbers in the batch
        ("flown", i8, ROWS),  # ticks of this decision
        *_lanes("tick deviation_m deviation_max_m flown_m nearest_m"),  # nearest_m: in this tick
        *_lanes("action", 3),
        *_lanes(  # as in CHANNEL
            "path_loss_factor offset_dbm white_std_db white_variance_db2 coloured_variance_db2 coloured_decay "
            "coloured_drive_db sensitivity_dbm"
        ),
        *_lanes("node_x_m node_y_m node_z_m node_range_m node_weight_pm2", 3),  # a fix by three nodes
    ]
)
AIRCRAFT_LANES = np.dtype(
    [
        *_lanes("held_s hover_until_s barometer_error_m datum_error_m solution_std_m"),  # as in AIRCRAFT
        *_lanes(
            "position_m velocity_mps gust_mps way_point_m planned_m planned_mps along gnss_error_m velocity_error_mps "
            "drift_m solution_m solution_mps",
            3,
        ),
        *_lanes("clock_s leg_s turn_s"),  # the aircraft's own time; start and end of its leg
        *_lanes("leg_m way_point_mps ground_mps", 3),  # start of the leg; velocities of way point and over ground
    ]
)
LINK_LANES = np.dtype(
    [
        *_lanes("coloured_db wander range_m coloured_hat_db p_dd p_dp p_pp rate_mps"),  # as in LINK
        *_lanes("coloured_normal white_normal distance_squared_m2 rss_dbm psi_m process_noise_m2"),  # of a tick
    ]
)
CONTACT_LANES = np.dtype(
    [
        # Motion relative to the agent before a tick, and the least separation in it
        *_lanes("relative_m relative_mps", 3),
        *_lanes("least_m least_squared_m2"),
        # What psi is made of: known is 1 while messages come
        *_lanes("position_m velocity_mps", 3),
        *_lanes("std_m known"),
    ]
)

CHANNEL = np.dtype(
    [
        ("path_loss_factor", f8),
        ("offset_dbm", f8),
        ("white_std_db", f8),
        ("white_variance_db2", f8),  # R of the filter: white noise and quantisation
        ("coloured_std_db", f8),
        ("coloured_variance_db2", f8),
        ("coloured_decay", f8),  # a = e^{lambda Delta}
        ("coloured_drive_db", f8),  # sigma_w2
        ("coloured_tc_s", f8),
        ("wander_std", f8),
        ("wander_decay", f8),
        ("wander_drive", f8),
        ("quantisation_db", f8),
        ("sensitivity_dbm", f8),
        ("packet_loss", f8),
    ]
)

FAMILY = np.dtype(
    [
        ("weight", f8),  # cumulative
        ("conflict_share", f8),
        ("crossing_min_rad", f8),
        ("crossing_max_rad", f8),
        ("offset_min_m", f8),
        ("offset_max_m", f8),
        ("own_turn_min_rad", f8),
        ("own_turn_max_rad", f8),
        ("own_bend_min_s", f8),  # before the closest approach; negative: after it
        ("own_bend_max_s", f8),
        ("faster", b1),  # the intruder than the agent
        ("bends", b1),  # the intruder's path has a way point on its way
        ("bend_min_s", f8),  # before the closest approach
        ("bend_max_s", f8),
        ("turn_min_rad", f8),
        ("turn_max_rad", f8),
        ("speed_change_min_mps", f8),
        ("speed_change_max_mps", f8),
        ("merging", b1),
        # What befalls messages and link
        ("announced_min_rad", f8),
        ("announced_max_rad", f8),
        ("onset_min_s", f8),
        ("onset_max_s", f8),
        ("jump_min", f8),
        ("jump_max", f8),
        ("outage_min_s", f8),
        ("outage_max_s", f8),
        # A hand-written encounter
        ("scripted", b1),
        ("own_mps", f8),
        ("start_m", f8, 3),
        ("velocity_mps", f8, 2),
        ("end_s", f8),
    ]
)

_CONFIG_FLOATS = (
    "tick_s decision_s tail_min_s tail_max_s speed_max_mps vertical_speed_max_mps acceleration_max_mps2 gust_mps "
    "gust_decay gust_drive_mps position_gain_ps2 velocity_gain_ps cruise_min_mps cruise_max_mps closing_min_mps "
    "start_min_m start_max_m time_to_approach_max_s horizontal_offset_m vertical_offset_m conflict_offset_m altitude_m "
    "altitude_band_m process_noise_m2 process_noise_psi_m2 bearing_inflation prior_range_m prior_std_m "
    "node_prior_range_m node_prior_std_m range_floor_m "
    "rate_gain gnss_m gnss_vertical_m gnss_decay gnss_drive barometer_m barometer_decay barometer_drive "
    "barometer_datum_m velocity_error_mps velocity_decay velocity_drive drift_mps drift_decay drift_drive "
    "radius_m range_error_probability reaction_s warning_close_ratio warning_close_s hover_s collision_m "
    "snmac_horizontal_m snmac_vertical_m announce_s message_loss deviation_price snmac_price_m collision_price_m "
    "proximity_price_m comfort_m shaping_m shaping_discount"
).split()
_CONFIG_INTS = (
    "ticks_per_decision intruders intruders_min estimator tracker agent_localisation intruder_localisation information "
    "latency_ticks trials".split()
)
CONFIG = np.dtype(
    [(name, f8) for name in _CONFIG_FLOATS]
    + [(name, i8) for name in _CONFIG_INTS]
    + [("planar", b1), ("zone_adaptive", b1), ("lossy", b1), ("wanders", b1), ("nodes_m", f8, (NODES, 3))]
)


class State(NamedTuple):
    """State of a batch of n environments with K intruder rows."""

    config: Any  # (1,) CONFIG
    channels: Any  # (c,) CHANNEL, drawn from per episode
    families: Any  # (f,) FAMILY
    episode: Any  # (n,) EPISODE
    aircraft: Any  # (n, 1 + K) AIRCRAFT
    links: Any  # (n, K + NODES (1 + K)) LINK
    contacts: Any  # (n, K) CONTACT
    mail: Any  # (n, K, 1 + latency in ticks) MESSAGE
    memories: Any  # (n, K, m) what the tracker remembers
    tracks: Any  # (n, K) TRACK
    model: Any  # (1,) what the tracker holds of the world
    used: Any  # (u,) the links that are ranged
    tick_streams: Any  # (2 u,) streams of their normals, coloured and white
    tick_normals: Any  # (n, 8 u) four of each: the standard normals of four ticks
    decision_streams: Any  # (s,) streams of the slow processes
    decision_normals: Any  # (n, 4 s) four of each: the standard normals of four decisions
    # The block at work
    block: Any  # (1,) BLOCK
    aircraft_lanes: Any  # (1 + K,) AIRCRAFT_LANES
    link_lanes: Any  # as many LINK_LANES as a row has links
    contact_lanes: Any  # (K,) CONTACT_LANES


def allocate(params: Params, families: np.ndarray, n: int) -> State:
    """A world of `n` rows that are all still to be reset."""
    k = params.encounter.intruders
    links, used = k + NODES * (1 + k), used_links(params)
    tick, decision = normal_streams(params, used)
    record = config(params)
    record["lossy"] |= np.any(families["outage_max_s"] > 0.0)
    return State(
        config=record,
        channels=channels(params),
        families=families,
        episode=np.zeros(n, EPISODE),
        aircraft=np.zeros((n, 1 + k), AIRCRAFT),
        links=np.zeros((n, links), LINK),
        contacts=np.zeros((n, k), CONTACT),
        mail=np.zeros((n, k, 1 + int(record["latency_ticks"][0])), MESSAGE),
        memories=np.zeros((n, k, tracking.memory_columns(params.tracking.tracker))),
        tracks=np.zeros((n, k), tracking.TRACK),
        model=tracking.model(params),
        used=used,
        tick_streams=tick,
        tick_normals=np.zeros((n, 4 * len(tick))),
        decision_streams=decision,
        decision_normals=np.zeros((n, 4 * len(decision))),
        block=np.zeros(1, BLOCK),
        aircraft_lanes=np.zeros(1 + k, AIRCRAFT_LANES),
        link_lanes=np.zeros(links, LINK_LANES),
        contact_lanes=np.zeros(k, CONTACT_LANES),
    )


def used_links(params: Params) -> np.ndarray:
    """Links to the intruders, and to the nodes of whoever is localised by radio; the others are never ranged."""
    k, sides = params.encounter.intruders, params.navigation
    by_radio = [a for a in range(1 + k) if (sides.intruder if a else sides.agent) == "rss"]
    return np.array([*range(k), *(k + NODES * a + j for a in by_radio for j in range(NODES))])


def normal_streams(params: Params, used: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Streams of the normals that are drawn for every tick and for every decision."""
    k = params.encounter.intruders
    g = [global_link(k, int(link)) for link in used]
    tick = [streams.STREAM_TICK + 2 * link + part for link in g for part in (0, 1)]

    # Gust, velocity and, where it is used, GNSS of each axis, then the barometer; in the plane nothing errs upwards.
    def processes(a: int) -> list[int]:
        uses_gnss = (params.navigation.intruder if a else params.navigation.agent) == "gnss"
        axes = [
            [axis, 6 + axis, *([3 + axis] if uses_gnss else [])] for axis in range(2 if params.encounter.planar else 3)
        ]
        return [process for axis in axes for process in axis] + ([] if params.encounter.planar else [9])

    aircraft = [streams.STREAM_AIRCRAFT + 10 * a + process for a in range(1 + k) for process in processes(a)]
    wander = [streams.STREAM_WANDER + link for link in g] if wanders(params) else []
    return np.array(tick), np.array(wander + aircraft)


def wanders(params: Params) -> bool:
    """Whether any path loss factor changes."""
    return any(channel.path_loss_wander > 0.0 for channel in params.channels)


def _process(record: Any, name: str, std: float, period_s: float, tc_s: float) -> None:
    """Write decay and driving standard deviation of one Gauss-Markov process into `record`."""
    from rss_gym.physics.noise import decay, driving_std

    a = decay(period_s, tc_s)
    record[f"{name}_decay"] = a
    record[f"{name}_drive" if f"{name}_drive" in record.dtype.names else f"{name}_drive_mps"] = driving_std(
        std * std, a
    )


def config(params: Params) -> np.ndarray:
    """The parameters and what the kernels derive from them, as one record. Shape (1,)."""
    p, out = params, np.zeros(1, CONFIG)
    record = out[0]
    for group in (p.clock, p.aircraft, p.encounter, p.ranging, p.navigation, p.messages, p.zone, p.reward):
        for name in group.__slots__:
            if name in _CONFIG_FLOATS or name in ("intruders", "intruders_min", "planar"):
                record[name] = getattr(group, name)
    unit_m = p.encounter.start_range_unit_m
    record["start_min_m"], record["start_max_m"] = (
        unit_m * p.encounter.start_range_min,
        unit_m * p.encounter.start_range_max,
    )
    record["ticks_per_decision"] = p.clock.ticks_per_decision
    record["position_gain_ps2"] = p.aircraft.position_gain_ps2
    record["velocity_gain_ps"] = p.aircraft.velocity_gain_ps
    record["intruders_min"] = p.encounter.intruders_min or p.encounter.intruders
    record["rate_gain"] = p.clock.tick_s / (p.clock.tick_s + p.ranging.rate_tc_s)
    record["radius_m"], record["trials"] = p.zone.radius_m, p.zone.trials
    record["lossy"] = any(channel.quantisation_db > 0.0 or channel.packet_loss > 0.0 for channel in p.channels)
    record["wanders"] = wanders(p)
    record["zone_adaptive"] = p.zone.zone == "adaptive"
    record["estimator"] = ESTIMATORS[p.ranging.estimator].code
    record["information"] = INFORMATION[p.interface.information]
    record["tracker"] = tracking.TRACKERS[p.tracking.tracker].code
    record["latency_ticks"] = round(p.messages.message_latency_s / p.clock.tick_s)
    record["agent_localisation"] = LOCALISATIONS[p.navigation.agent]
    record["intruder_localisation"] = LOCALISATIONS[p.navigation.intruder]
    nav, period_s = p.navigation, p.clock.decision_s
    record["velocity_error_mps"], record["drift_mps"] = nav.velocity_mps, nav.dead_reckoning_mps
    _process(record, "gust", p.aircraft.gust_mps, period_s, p.aircraft.gust_tc_s)
    _process(record, "gnss", 1.0, period_s, nav.gnss_tc_s)
    _process(record, "barometer", nav.barometer_m, period_s, nav.barometer_tc_s)
    _process(record, "velocity", nav.velocity_mps, period_s, nav.velocity_tc_s)
    _process(record, "drift", nav.dead_reckoning_mps, period_s, nav.dead_reckoning_tc_s)
    half_m = 0.5 * nav.node_square_m
    low_m, high_m = nav.node_height_low_m, nav.node_height_high_m
    record["nodes_m"] = [
        [-half_m, -half_m, low_m],
        [half_m, -half_m, high_m],
        [half_m, half_m, low_m],
        [-half_m, half_m, high_m],
    ]
    return out


def channels(params: Params) -> np.ndarray:
    """The channels and what the kernels derive from them. Shape (c,)."""
    out = np.zeros(len(params.channels), CHANNEL)
    for record, channel in zip(out, params.channels, strict=True):
        for name in channel.__slots__:
            if name in (CHANNEL.names or ()):
                record[name] = getattr(channel, name)
        record["white_std_db"] = np.sqrt(channel.white_variance_db2)
        # The rounding error of a quantiser is uniform: variance step^2 / 12. A floor keeps the filter's R positive.
        record["white_variance_db2"] = max(channel.white_variance_db2 + channel.quantisation_db**2 / 12.0, 1e-6)
        record["coloured_std_db"], record["wander_std"] = (
            np.sqrt(channel.coloured_variance_db2),
            channel.path_loss_wander,
        )
        _process(record, "wander", channel.path_loss_wander, params.clock.decision_s, channel.path_loss_wander_tc_s)
        from rss_gym.physics.noise import decay, driving_std

        a = decay(params.clock.tick_s, channel.coloured_tc_s)
        record["coloured_decay"], record["coloured_drive_db"] = a, driving_std(channel.coloured_variance_db2, a)
    return out


def global_link(k: int, link: int) -> int:
    """g, the number of `link` that its streams carry: the same whatever the number K = `k` of intruders."""
    return link if link < k else MAX_INTRUDERS + link - k
