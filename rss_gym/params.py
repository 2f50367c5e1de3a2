"""Every number of the world, as frozen dataclasses with the unit in the name.

`Params` groups them; `Params.of(**keywords)` sets any field of any group by its name, `Params.from_dict` reads what
`Params.to_dict` wrote, so that the parameters travel in a JSON environment spec. Derived values are properties.
Wrong names, types and ranges raise `ParamsError` (a `ValueError`) in one sentence.
"""

from __future__ import annotations

import dataclasses
import math
import os
import types
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from rss_gym.errors import ParamsError, UnknownParamError, suggestion
from rss_gym.plain_files import read_toml
from rss_gym.registry import Registry
from rss_gym.registry import of as registry_of
from rss_gym.schema import Kind, argument, one_of, optional, real, truth, whole
from rss_gym.streams import MAX_INTRUDERS

PRESETS_FOLDER = Path(__file__).parent / "presets"
CHANNEL_BYTES_MAX = 65536  # of a channel file
RADIOS = "radios"  # the name of the list of all presets but `clean`, and of as many random radios as this:
RANDOM_RADIOS = 59

Information = Literal["oracle", "positions", "ranges"]
Localisation = Literal["gnss", "rss", "dead-reckoning"]
ActionKind = Literal["velocity", "discrete"]
ZoneKind = Literal["fixed", "adaptive"]


def number(default: float, low: float, high: float) -> Any:
    """A dataclass field that must be a finite number in [low, high], a whole one if the default is."""
    kind = whole(int(low), int(high)) if isinstance(default, int) else real(low, high)
    return of_kind(default, kind, low=low, high=high)


def choice(default: str | None, names: Any) -> Any:
    """A dataclass field that must be one of these names, or of a `Literal`'s (or None if that is the default)."""
    names = typing.get_args(names) or tuple(names)
    kind = one_of(names)
    return of_kind(default, optional(kind) if default is None else kind, known=names)


def part(default: str, registry: str) -> Any:
    """A dataclass field that names a part of the registry of that kind, one that flies."""

    def names() -> list[str]:
        return [name for name, part in registry_of(registry).items() if getattr(part, "flies", True)]

    def test(value: Any) -> bool:  # the default is there; looking it up would load kernels
        return isinstance(value, str) and (value == default or value in names())

    return of_kind(default, Kind(test, f"the name of a registered {registry}", names))


def of_kind(default: Any, kind: Kind, **more: Any) -> Any:
    """A dataclass field that must be of a kind, with `more` metadata."""
    return field(default=default, metadata={"kind": kind, **more})


def kind_of(item: dataclasses.Field[Any]) -> Kind | None:
    """The kind of a field of a group; None where the group checks it itself."""
    return item.metadata.get("kind") or (truth() if isinstance(item.default, bool) else None)


class Group:
    """A frozen dataclass whose fields check themselves: the kind of each stands in its metadata."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Check every field against its kind."""
        for item in dataclasses.fields(self):  # type: ignore[arg-type]
            kind = kind_of(item)
            if kind is not None:
                object.__setattr__(self, item.name, argument(item.name, getattr(self, item.name), kind))

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain JSON types."""
        return _plain(dataclasses.asdict(self))  # type: ignore[call-overload]

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed; unknown names raise `ParamsError`."""
        _refuse_unknown(type(self).__name__, changes, (f.name for f in dataclasses.fields(self)))  # type: ignore[arg-type]
        return dataclasses.replace(self, **changes)  # type: ignore[type-var]


def _ordered(group: Any, low: str, high: str) -> None:
    """Refuse limits in the wrong order."""
    if getattr(group, low) > getattr(group, high):
        raise ParamsError(f"{low} = {getattr(group, low):g} must not exceed {high} = {getattr(group, high):g}")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def refuse_keywords(where: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse keywords of a call that are not among the known ones, in the words that Python itself uses.

    Raises
    ------
    UnknownParamError
        For the first such keyword.
    """
    names = list(known)
    for name in given:
        if name not in names:
            raise UnknownParamError(
                f"got an unexpected keyword argument {name!r}: {where} has no parameter {name!r}"
                f"{suggestion(name, names)}"
            )


def _refuse_unknown(where: str, given: Iterable[str], known: Iterable[str]) -> None:
    names = list(known)
    for name in given:
        if name not in names:
            raise ParamsError(f"{where} has no parameter {name!r}{suggestion(str(name), names)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock(Group):
    """Periods of the radio and of the policy, and how long a flight goes on after the planned closest approach."""

    tick_s: float = number(0.1, 0.01, 1.0)
    decision_s: float = number(0.5, 0.01, 10.0)
    tail_min_s: float = number(15.0, 0.0, 300.0)
    tail_max_s: float = number(45.0, 0.0, 300.0)

    def __post_init__(self) -> None:
        """Check that a decision is a whole number of ticks, and the order of the limits."""
        Group.__post_init__(self)
        _ordered(self, "tail_min_s", "tail_max_s")
        ratio = self.decision_s / self.tick_s
        if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6:
            raise ParamsError(
                f"decision_s must be a whole multiple of tick_s = {self.tick_s:g}, got {self.decision_s!r}"
            )

    @property
    def ticks_per_decision(self) -> int:
        """Radio ticks in one decision of the policy."""
        return round(self.decision_s / self.tick_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Aircraft(Group):
    """Limits of the point mass, its gusts and the weights of its autopilot, the regulator of (42)."""

    speed_max_mps: float = number(5.0, 0.5, 50.0)
    vertical_speed_max_mps: float = number(2.0, 0.1, 20.0)
    acceleration_max_mps2: float = number(2.0, 0.1, 50.0)
    gust_mps: float = number(0.2, 0.0, 5.0)
    gust_tc_s: float = number(3.0, 0.1, 600.0)
    regulator_position_weight: float = number(1.0, 1e-3, 1e3)
    regulator_velocity_weight: float = number(1.0, 0.0, 1e3)
    regulator_effort_weight: float = number(1.0, 1e-3, 1e3)

    @property
    def position_gain_ps2(self) -> float:
        """k1 = sqrt(q / r) of the double integrator, 1/s^2."""
        return math.sqrt(self.regulator_position_weight / self.regulator_effort_weight)

    @property
    def velocity_gain_ps(self) -> float:
        """k2 = sqrt(2 k1 + qv / r), 1/s."""
        return math.sqrt(2.0 * self.position_gain_ps2 + self.regulator_velocity_weight / self.regulator_effort_weight)


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter(Group):
    """The published distribution of encounters; `families` names one family, several, or `mixed`."""

    planar: bool = True
    intruders: int = number(1, 1, MAX_INTRUDERS)
    intruders_min: int = number(0, 0, MAX_INTRUDERS)  # 0: always `intruders`
    families: str | tuple[str, ...] = "mixed"
    cruise_min_mps: float = number(2.0, 0.2, 50.0)
    cruise_max_mps: float = number(4.0, 0.2, 50.0)
    closing_min_mps: float = number(1.5, 0.1, 50.0)
    start_range_min: float = number(1.1, 0.5, 5.0)  # in start_range_unit_m
    start_range_max: float = number(1.6, 0.5, 5.0)
    start_range_unit_m: float = number(120.0, 10.0, 5000.0)
    time_to_approach_max_s: float = number(75.0, 5.0, 600.0)
    horizontal_offset_m: float = number(60.0, 5.0, 1000.0)
    vertical_offset_m: float = number(20.0, 5.0, 1000.0)
    conflict_offset_m: float = number(3.0, 0.0, 100.0)
    altitude_m: float = number(20.0, 0.0, 5000.0)
    altitude_band_m: float = number(15.0, 1.0, 1000.0)  # the way point stays this near the predefined altitude

    def __post_init__(self) -> None:
        """Check the order of limits and normalise `families`."""
        Group.__post_init__(self)
        _ordered(self, "cruise_min_mps", "cruise_max_mps")
        _ordered(self, "start_range_min", "start_range_max")
        _ordered(self, "intruders_min", "intruders")
        if 2.0 * self.cruise_max_mps < self.closing_min_mps:
            raise ParamsError(
                f"closing_min_mps = {self.closing_min_mps:g} can never be reached with cruise_max_mps = "
                f"{self.cruise_max_mps:g}; it must be at most twice that"
            )
        names = [self.families] if isinstance(self.families, str) else self.families
        if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
            raise ParamsError(f"families must be a name or a list of names, got {self.families!r}")
        object.__setattr__(self, "families", names[0] if len(names) == 1 else tuple(names))


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel(Group):
    """One radio channel: path loss (2)-(3), white noise, and coloured noise (7)-(11) by its variance and time."""

    path_loss_factor: float = number(2.7, 1.0, 8.0)
    offset_dbm: float = number(-35.0, -150.0, 60.0)  # P_t + 10 log10 K: the RSS at 1 m
    white_variance_db2: float = number(4.0, 0.0, 400.0)
    coloured_variance_db2: float = number(4.0, 1e-6, 400.0)
    coloured_tc_s: float = number(2.0, 0.01, 3600.0)
    path_loss_wander: float = number(0.05, 0.0, 2.0)
    path_loss_wander_tc_s: float = number(60.0, 0.1, 36000.0)
    quantisation_db: float = number(0.0, 0.0, 20.0)
    sensitivity_dbm: float = number(-200.0, -300.0, 0.0)
    packet_loss: float = number(0.0, 0.0, 0.99)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranging(Group):
    """The estimator of range and its tuning; `ranging/` holds the filters, (12)-(21)."""

    estimator: str = part("ekf-coloured", "estimator")
    process_noise_m2: float = number(64.0, 1e-6, 1e6)  # Var(w) a tick without psi
    # 2 Tv Delta sigma_v^2 of both velocities is 1; a slow radio needs somewhat more for errors as large as stated.
    process_noise_psi_m2: float = number(1.2, 1e-6, 1e6)
    bearing_inflation: float = number(60.0, 0.0, 1e4)  # the bearing's error persists over this many ticks
    prior_range_m: float = number(160.0, 1.0, 1e4)
    prior_std_m: float = number(60.0, 0.1, 1e4)
    node_prior_range_m: float = number(150.0, 1.0, 1e4)
    node_prior_std_m: float = number(100.0, 0.1, 1e4)
    range_floor_m: float = number(0.3, 0.01, 10.0)
    rate_tc_s: float = number(2.0, 0.1, 60.0)  # smoothing of the published range rate


@dataclass(frozen=True, slots=True, kw_only=True)
class Navigation(Group):
    """How each side knows its own position, and the errors of these solutions."""

    agent: str = choice("rss", Localisation)
    intruder: str = choice("rss", Localisation)
    gnss_m: float = number(1.0, 0.0, 100.0)
    gnss_vertical_m: float = number(2.0, 0.0, 100.0)
    gnss_tc_s: float = number(30.0, 0.1, 3600.0)
    barometer_m: float = number(1.0, 0.0, 100.0)
    barometer_tc_s: float = number(60.0, 0.1, 3600.0)
    barometer_datum_m: float = number(3.0, 0.0, 100.0)
    velocity_mps: float = number(0.2, 0.0, 10.0)
    velocity_tc_s: float = number(60.0, 0.1, 3600.0)
    dead_reckoning_mps: float = number(0.1, 0.0, 10.0)
    dead_reckoning_tc_s: float = number(60.0, 0.1, 3600.0)
    node_square_m: float = number(300.0, 10.0, 5000.0)
    node_height_low_m: float = number(0.0, 0.0, 500.0)
    node_height_high_m: float = number(15.0, 0.0, 500.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracking(Group):
    """The tracker that makes one relative state of messages and ranges; `tracking/` holds them."""

    tracker: str = part("fused", "tracker")
    track_range: bool = True  # False: `fused` leaves the range out, to measure what it is worth
    unheard_mps: float = number(1.0, 0.0, 10.0)  # error of an intruder's velocity that is no longer told
    unheard_tc_s: float = number(5.0, 0.1, 60.0)  # how long that error lasts
    # `fused` holds that a fix, or a range, of stated std s at distance d errs by s^2 (1 + k (s / d)^2).
    message_share: float = number(30.0, 0.0, 1e3)
    range_share: float = number(8.0, 0.0, 1e3)
    range_repeat: float = number(2.0, 0.0, 100.0)  # and that a range repeats its error for so many correlation times
    miss_std_m: float = number(42.0, 1.0, 1e6)  # `bearings`: prior of the distance at which the intruder passes
    rest_inflation: float = number(3.0, 0.1, 100.0)  # and factor on the variance of the range beside coloured noise


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone(Group):
    """The safety zone (29)-(40), its warning with hysteresis, and the events on true states."""

    zone: str = choice("fixed", ZoneKind)
    range_error_m: float = number(4.0, 0.01, 1000.0)  # delta
    range_error_probability: float = number(0.8, 0.01, 0.999)  # P(delta)
    speed_relative_max_mps: float = number(10.0, 0.1, 100.0)
    reaction_s: float = number(1.0, 0.01, 60.0)
    collision_probability: float = number(1e-5, 1e-12, 0.5)
    warning_close_ratio: float = number(1.2, 1.0, 5.0)
    warning_close_s: float = number(2.0, 0.0, 60.0)
    hover_s: float = number(5.0, 0.0, 60.0)
    collision_m: float = number(4.5, 0.1, 100.0)
    snmac_horizontal_m: float = number(15.24, 0.1, 1000.0)
    snmac_vertical_m: float = number(4.57, 0.1, 1000.0)

    def __post_init__(self) -> None:
        """Check that the events are nested: a collision is an sNMAC, and that is a violation of the zone."""
        Group.__post_init__(self)
        horizontal_m, vertical_m = self.snmac_horizontal_m, self.snmac_vertical_m
        if self.collision_m > min(horizontal_m, vertical_m):
            raise ParamsError(
                f"collision_m = {self.collision_m:g} must not exceed snmac_vertical_m = {vertical_m:g} or "
                f"snmac_horizontal_m = {horizontal_m:g}, so that every collision is an sNMAC"
            )
        if math.hypot(horizontal_m, vertical_m) > self.radius_m:
            raise ParamsError(
                f"the zone radius (40) is {self.radius_m:g} m and must hold the sNMAC limits, {horizontal_m:g} m "
                f"horizontally and {vertical_m:g} m vertically"
            )

    @property
    def trials(self) -> int:
        """n_d of (37), rounded towards infinity."""
        return math.ceil(math.log(self.collision_probability) / math.log(1.0 - self.range_error_probability) - 1e-12)

    @property
    def radius_m(self) -> float:
        """S of (40) at the stated accuracy and relative speed."""
        reach = self.range_error_m / self.range_error_probability + self.speed_relative_max_mps * self.reaction_s
        return reach * self.trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface(Group):
    """What the policy is told and how it commands."""

    information: str = choice("positions", Information)
    action: str = choice("velocity", ActionKind)


@dataclass(frozen=True, slots=True, kw_only=True)
class Messages(Group):
    """What intruders send while the warning is open, and what becomes of it on the way."""

    announce_s: float = number(5.0, 0.0, 60.0)  # the next way point is where the sender plans to be so much later
    message_latency_s: float = number(0.0, 0.0, 10.0)
    message_loss: float = number(0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reward(Group):
    """Prices of the cost, in metres of mean deviation; the reward is minus the cost.

    The proximity price and the shaping are for training only and are zero in every score. The shaping is the
    discounted gain of the potential -`shaping_m` max(0, 1 - d / `comfort_m`)^2 (Ng, Harada and Russell, 1999), where
    d is the true least distance that straight flight will lead to; it leaves the optimal policy as it is.
    """

    deviation_price: float = number(1.0, 0.0, 1e3)
    snmac_price_m: float = number(100.0, 0.0, 1e7)
    collision_price_m: float = number(10000.0, 0.0, 1e7)
    proximity_price_m: float = number(0.0, 0.0, 1e6)  # of a decision spent at distance 0; falls to 0 at comfort_m
    comfort_m: float = number(35.0, 0.1, 1000.0)
    shaping_m: float = number(0.0, 0.0, 1e6)
    shaping_discount: float = number(0.99, 0.0, 1.0)


@dataclass(frozen=True)
class Preset:
    """A named channel: its numbers, or the TOML file that holds them, and where they are from."""

    source: Channel | Path
    text: str = ""

    @property
    def summary(self) -> str:
        """One line for listings: that given, or the file's first comment."""
        if self.text or isinstance(self.source, Channel):
            return self.text
        return self.source.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")


def _check_preset(name: str, preset: Preset) -> None:
    if name == RADIOS:
        raise ParamsError(f"channel name {RADIOS!r} stands for all presets; give the new one another name")
    if not isinstance(preset, Preset) or not isinstance(preset.text, str) or not preset.text.strip():
        raise ParamsError(f"channel {name!r} must have a summary, one line that says where its numbers are from")


CHANNELS: Registry[Preset] = Registry(
    "channel",
    {path.stem: Preset(path) for path in sorted(PRESETS_FOLDER.glob("*.toml"))},
    _check_preset,
    like="my-radio",
)


def load_channel(source: str | os.PathLike[str] | Mapping[str, Any] | Channel) -> Channel:
    """A channel from a preset's name, a TOML file, a dict, or a `Channel` as it is.

    Raises
    ------
    ParamsError
        When no preset or file has that name, or the file is not a channel: the sentence names file, field and value.
    """
    if isinstance(source, Channel):
        return source
    if isinstance(source, Mapping):
        _refuse_unknown("channel", source, (f.name for f in dataclasses.fields(Channel)))
        return Channel(**source)
    if not isinstance(source, (str, os.PathLike)):
        raise ParamsError(f"channel must be a preset's name, a TOML file, a dict or a list of these, got {source!r}")
    text = os.fspath(source)
    preset = CHANNELS.get(text)
    path = Path(text) if preset is None else preset.source
    if isinstance(path, Channel):
        return path
    if preset is None and not os.path.exists(path):  # Path.is_file raises for a name that is too long
        if path.suffix == ".toml" or len(path.parts) > 1:
            raise ParamsError(f"channel file {text!r} does not exist")
        raise ParamsError(f"channel preset {text!r} is unknown{suggestion(text, [*CHANNELS, RADIOS])}")
    try:
        table = read_toml(path, CHANNEL_BYTES_MAX)
    except ParamsError as error:
        raise ParamsError(f"channel file {text!r} {error}") from error
    try:
        _refuse_unknown("the file", table, ["channel"])
        if not isinstance(table.get("channel"), Mapping):
            raise ParamsError("there is no table [channel]")
        return load_channel(table["channel"])
    except ParamsError as error:
        raise ParamsError(f"channel file {text!r}: {error}") from error


def random_channels(count: int, seed: int) -> list[Channel]:
    """`count` random radios over the span of real logs: gamma uniform, the variances and the time log-uniform."""
    rng = np.random.Generator(np.random.PCG64(seed))

    def log_uniform(low: float, high: float) -> float:
        return round(float(low * (high / low) ** rng.random()), 4)

    return [
        Channel(
            path_loss_factor=round(float(rng.uniform(1.8, 4.0)), 4),
            white_variance_db2=log_uniform(0.05, 6.0),
            coloured_variance_db2=log_uniform(1.0, 40.0),
            coloured_tc_s=log_uniform(0.1, 8.0),
        )
        for _ in range(count)
    ]


def _channels(value: Any) -> tuple[Channel, ...]:
    items = value if isinstance(value, (list, tuple)) else [value]
    if not items:
        raise ParamsError("channel list is empty; name at least one preset or file")
    if RADIOS in items:
        named = [load_channel(name) for name in CHANNELS.shipped if name != "clean"]
        radios = [*named, *random_channels(RANDOM_RADIOS, seed=0)]
        items = [radio for item in items for radio in (radios if item == RADIOS else [item])]
    return tuple(load_channel(item) for item in items)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params(Group):
    """All parameters of the world. Fields are the groups above; `channels` are drawn from once per episode."""

    clock: Clock = field(default_factory=Clock)
    aircraft: Aircraft = field(default_factory=Aircraft)
    encounter: Encounter = field(default_factory=Encounter)
    channels: tuple[Channel, ...] = field(default_factory=lambda: (load_channel("paper"),))
    ranging: Ranging = field(default_factory=Ranging)
    navigation: Navigation = field(default_factory=Navigation)
    messages: Messages = field(default_factory=Messages)
    tracking: Tracking = field(default_factory=Tracking)
    zone: Zone = field(default_factory=Zone)
    interface: Interface = field(default_factory=Interface)
    reward: Reward = field(default_factory=Reward)

    def __post_init__(self) -> None:
        """Check the groups' types and the contradictions between them."""
        for name, kind in _GROUPS.items():
            if not isinstance(getattr(self, name), kind):
                raise ParamsError(f"params.{name} must be a {kind.__name__}")
        object.__setattr__(self, "channels", _channels(self.channels))
        nav = self.navigation
        ranges = self.interface.information == "ranges"
        if ranges and "rss" in (nav.agent, nav.intruder):
            raise ParamsError(
                "information 'ranges' has fewer than three reference nodes and exchanges no position, so agent and "
                "intruder must be 'dead-reckoning' or 'gnss', "
                f"got agent = {nav.agent!r}, intruder = {nav.intruder!r}"
            )
        if ranges or self.tracking.tracker != Tracking().tracker:  # else that of the default, which loads no kernels
            needed, trackers = "ranges" if ranges else "positions", registry_of("tracker")
            if needed not in trackers[self.tracking.tracker].information:
                able = ", ".join(repr(name) for name, part in trackers.items() if needed in part.information)
                raise ParamsError(
                    f"tracker {self.tracking.tracker!r} cannot work with information "
                    f"{self.interface.information!r}, where messages hold {'no ' if ranges else ''}positions; "
                    f"those that can: {able}"
                )
        if self.encounter.cruise_max_mps >= self.aircraft.speed_max_mps:
            raise ParamsError(
                f"cruise_max_mps = {self.encounter.cruise_max_mps:g} must be below speed_max_mps = "
                f"{self.aircraft.speed_max_mps:g}, or the aircraft cannot regain its path"
            )

    @classmethod
    def of(cls, params: Params | Mapping[str, Any] | None = None, **keywords: Any) -> Params:
        """`params` (the dataclass, its dict, or the defaults) with any field of any group set by its own name.

        `channel=` takes a preset's name, a TOML file, a dict, or a list of these.

        Raises
        ------
        UnknownParamError
            For an unknown name (with the nearest known one).
        ParamsError
            For a wrong type or range, or a contradiction.
        """
        if isinstance(params, Params) and type(params) is not cls:  # those of a road have names of their own
            return type(params).of(params, **keywords)
        base = params if isinstance(params, Params) else cls.from_dict(params) if params is not None else cls()
        refuse_keywords("rss_gym", keywords, [*_OWNER, "channel"])
        changes: dict[str, Any] = {}
        if "channel" in keywords:
            changes["channels"] = _channels(keywords.pop("channel"))
        if keywords.get("information") == "ranges" and base.interface.information != "ranges":
            keywords = RANGES_IMPLY | keywords
        # All fields of a group are set before any is checked: linked ones may be given in any order.
        given: dict[str, dict[str, Any]] = {}
        for name, value in keywords.items():
            given.setdefault(_OWNER[name], {})[name] = value
        changes |= {group: getattr(base, group).replace(**fields) for group, fields in given.items()}
        return dataclasses.replace(base, **changes) if changes else base

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> Params:
        """The parameters that `to_dict` wrote; missing groups and fields keep their defaults."""
        if not isinstance(table, Mapping):
            raise ParamsError(f"params must be a Params or the dict it becomes in JSON, got {type(table).__name__}")
        _refuse_unknown("params", table, [*_GROUPS, "channels"])
        groups: dict[str, Any] = {}
        for name, value in table.items():
            if name == "channels":
                groups[name] = _channels(value)
            elif isinstance(value, Mapping):
                _refuse_unknown(f"params.{name}", value, (f.name for f in dataclasses.fields(_GROUPS[name])))
                groups[name] = _GROUPS[name](**value)
            else:
                raise ParamsError(f"params.{name} must be a table, got {value!r}")
        return cls(**groups)


# Fewer than three nodes leave nobody a solution by radio, and there are no positions to fuse.
RANGES_IMPLY = {"agent": "dead-reckoning", "intruder": "dead-reckoning", "tracker": "bearings"}
_GROUPS: dict[str, Any] = {
    "clock": Clock,
    "aircraft": Aircraft,
    "encounter": Encounter,
    "ranging": Ranging,
    "navigation": Navigation,
    "messages": Messages,
    "tracking": Tracking,
    "zone": Zone,
    "interface": Interface,
    "reward": Reward,
}
# Field names are unique over the groups (tested), so a keyword needs no group.
_OWNER = types.MappingProxyType({f.name: name for name, group in _GROUPS.items() for f in dataclasses.fields(group)})
