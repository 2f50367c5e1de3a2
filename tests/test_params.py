"""Every number of the world: round trips, ranges, derived values, presets."""

import dataclasses
import itertools
import json
import math
import pickle

import gymnasium as gym
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rss_gym  # noqa: F401
from rss_gym.params import (
    CHANNELS,
    RANGES_IMPLY,
    Aircraft,
    Channel,
    Clock,
    Encounter,
    Params,
    ParamsError,
    Zone,
    load_channel,
)

GROUPS = {f.name: type(getattr(Params(), f.name)) for f in dataclasses.fields(Params) if f.name != "channels"}
FIELDS = [(group, f) for group in [*GROUPS.values(), Channel] for f in dataclasses.fields(group)]
NUMBERS = [(group, f) for group, f in FIELDS if "low" in f.metadata]
CHOICES = [(group, f) for group, f in FIELDS if "known" in f.metadata]


def _ids(pairs):
    return [f"{group.__name__}.{f.name}" for group, f in pairs]


def _through_json(params):
    return Params.from_dict(json.loads(json.dumps(params.to_dict(), allow_nan=False)))


# A few fields of every group, with ranges in which no two contradict each other.
SOME = st.fixed_dictionaries(
    {},
    optional={
        "tail_max_s": st.floats(15.0, 300.0),
        "gust_mps": st.floats(0.0, 5.0),
        "planar": st.booleans(),
        "intruders": st.integers(1, 8),
        "families": st.sampled_from(["crossing", ("crossing", "turning"), ["head-on", "overtaking"], "mixed"]),
        "estimator": st.sampled_from(["ekf-coloured", "ekf-white", "ekf-white-r", "ls"]),
        "process_noise_m2": st.floats(1e-6, 1e6),
        "gnss_m": st.floats(0.0, 100.0),
        "agent": st.sampled_from(["gnss", "rss", "dead-reckoning"]),
        "zone": st.sampled_from(["fixed", "adaptive"]),
        "reaction_s": st.floats(0.01, 60.0),
        "announce_s": st.floats(0.0, 60.0),
        "tracker": st.sampled_from(["latest", "fused"]),
        "collision_price_m": st.integers(0, 10**6),  # a whole number where a float is meant
        "channel": st.sampled_from(["paper", "quadcopter", ["paper", "clean"], {"path_loss_factor": 3.1}]),
    },
)


def test_defaults_round_trip():
    assert _through_json(Params()) == Params()
    assert pickle.loads(pickle.dumps(Params())) == Params()
    assert hash(Params()) == hash(_through_json(Params()))


@settings(max_examples=60)
@given(SOME)
def test_any_parameters_round_trip(keywords):
    params = Params.of(**keywords)
    assert _through_json(params) == params
    assert Params.of(params) == params
    assert Params.of(params.to_dict()) == params
    assert pickle.loads(pickle.dumps(params)) == params
    for name, value in keywords.items():
        if name not in ("channel", "families"):
            owner = next(group for group in GROUPS if name in {f.name for f in dataclasses.fields(GROUPS[group])})
            assert getattr(getattr(params, owner), name) == value


def test_field_names_are_unique_over_groups():
    names = [f.name for group in GROUPS.values() for f in dataclasses.fields(group)]
    assert len(names) == len(set(names))
    # `Params.of` takes these beside the fields, and the groups' own names must not hide one.
    assert not {"channel", "channels", "params", *GROUPS} - {"zone"} & set(names)


def test_every_field_is_checked():
    """A field is a number with a range, a choice, a switch, or the families, which check themselves."""
    for group, f in FIELDS:
        assert f.metadata or isinstance(f.default, bool) or f.name == "families", f"{group.__name__}.{f.name}"


def test_every_number_has_its_unit_or_none():
    """Ratios, probabilities, counts, gains and weights carry no unit; every other name ends in one."""
    units = ("_s", "_m", "_mps", "_mps2", "_m2", "_db", "_db2", "_dbm", "_pm", "_spm")
    bare = {
        "regulator_position_weight", "regulator_velocity_weight", "regulator_effort_weight", "intruders",
        "intruders_min", "start_range_min", "start_range_max", "path_loss_factor", "path_loss_wander", "packet_loss",
        "bearing_inflation", "range_error_probability", "collision_probability", "warning_close_ratio", "message_loss",
        "deviation_price", "shaping_discount", "message_share", "range_share", "range_repeat",
        "rest_inflation",
    }  # fmt: skip
    assert {f.name for _, f in NUMBERS if not f.name.endswith(units)} == bare


@pytest.mark.parametrize(("group", "item"), NUMBERS, ids=_ids(NUMBERS))
def test_every_range_is_enforced(group, item):
    low, high, default = item.metadata["low"], item.metadata["high"], item.default
    assert low <= default <= high
    whole = isinstance(default, int)
    below, above = (low - 1, high + 1) if whole else (math.nextafter(low, -math.inf), math.nextafter(high, math.inf))
    for bad in (below, above, math.nan, math.inf, -math.inf, None, "1", True, [1.0]):
        with pytest.raises(ParamsError, match=item.name):
            group(**{item.name: bad})
    if whole:
        with pytest.raises(ParamsError, match="whole number"):
            group(**{item.name: float(default)})
    for edge in (low, high):
        try:
            assert getattr(group(**{item.name: edge}), item.name) == edge
        except ParamsError as error:  # within its range, but not beside the defaults of the others
            assert "must be a number in" not in str(error)


@pytest.mark.parametrize(("group", "item"), CHOICES, ids=_ids(CHOICES))
def test_every_choice_is_enforced(group, item):
    known = item.metadata["known"]
    assert item.default in known
    for name in known:
        assert getattr(group(**{item.name: name}), item.name) == name
    for bad in ("no-such", "", 1, None, known):
        with pytest.raises(ParamsError, match=item.name):
            group(**{item.name: bad})
    with pytest.raises(ParamsError, match=f"did you mean '{known[0]}'"):
        group(**{item.name: known[0] + "x"})


@pytest.mark.parametrize("group", [*GROUPS.values(), Channel], ids=lambda group: group.__name__)
def test_groups_are_frozen_and_refuse_unknown_names(group):
    one = group()
    name = dataclasses.fields(group)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(one, name, getattr(one, name))
    with pytest.raises(ParamsError, match=f"did you mean '{name}'"):
        one.replace(**{name + "x": 1})
    assert one.replace() == one
    assert json.loads(json.dumps(one.to_dict())) == one.to_dict()


@pytest.mark.parametrize(
    ("keywords", "sentence"),
    [
        ({"cruise_min_mps": 4.5}, "cruise_min_mps"),
        ({"start_range_min": 2.0}, "start_range_min"),
        ({"intruders_min": 3, "intruders": 2}, "intruders_min"),
        ({"closing_min_mps": 9.0}, "closing_min_mps"),
        ({"cruise_max_mps": 5.0}, "cruise_max_mps"),
        ({"decision_s": 0.25}, "decision_s"),
        ({"decision_s": 0.05}, "decision_s"),
        ({"information": "ranges", "intruder": "rss"}, "information 'ranges'"),
        ({"information": "ranges", "tracker": "latest"}, "tracker 'latest'"),
        ({"tracker": "bearings"}, "tracker 'bearings'"),
        ({"tail_min_s": 50.0}, "tail_min_s"),
        ({"collision_m": 5.0}, "collision_m"),
        ({"snmac_horizontal_m": 130.0}, "zone radius"),
        ({"families": []}, "families"),
        ({"families": 3}, "families"),
        ({"channel": []}, "channel"),
        ({"announce": 3.0}, "did you mean 'announce_s'"),
    ],
)
def test_contradictions_are_refused(keywords, sentence):
    with pytest.raises(ParamsError, match=sentence):
        Params.of(**keywords)


DEFAULTS = {
    f.name: getattr(getattr(Params(), name), f.name) for name, g in GROUPS.items() for f in dataclasses.fields(g)
}
# Changes that are fine together; at least one of each pair is refused alone.
LINKED = [
    {"intruders": 3, "intruders_min": 2},
    {"tick_s": 1.0, "decision_s": 1.0},
    {"tail_min_s": 60.0, "tail_max_s": 70.0},
    {"tail_min_s": 0.0, "tail_max_s": 0.0},
    {"cruise_min_mps": 4.2, "cruise_max_mps": 4.5},
    {"cruise_min_mps": 0.5, "cruise_max_mps": 1.0},
    {"cruise_max_mps": 7.0, "speed_max_mps": 9.0},
    {"cruise_min_mps": 0.3, "cruise_max_mps": 0.7, "closing_min_mps": 0.5},
    {"closing_min_mps": 8.8, "cruise_max_mps": 4.5},
    {"start_range_min": 2.0, "start_range_max": 2.5},
    {"start_range_min": 0.6, "start_range_max": 0.7},
    {"collision_m": 6.0, "snmac_vertical_m": 7.0},
    {"collision_m": 20.0, "snmac_vertical_m": 20.0, "snmac_horizontal_m": 30.0},
    {"snmac_horizontal_m": 130.0, "reaction_s": 3.0},
    {"range_error_m": 0.5, "reaction_s": 0.1, "snmac_horizontal_m": 5.0},
    {"information": "ranges", "tracker": "bearings"},
    {"information": "ranges", "agent": "gnss", "intruder": "gnss"},
]


@pytest.mark.parametrize("changes", LINKED, ids=" ".join)
def test_linked_parameters_in_any_order(changes):
    """They are checked after all are set: as keywords, one environment's or another's, and from sorted JSON."""
    wanted = Params.of(**changes)
    for order in itertools.permutations(changes):
        keywords = {name: changes[name] for name in order}
        assert Params.of(**keywords) == wanted
        assert Params.of(Params(), **keywords) == wanted
        assert Params.of(Params().to_dict(), **keywords) == wanted
    for reverse in (False, True):
        for name in ("rss_gym/Encounter-v0", "rss_gym/Encounter3D-v0"):
            keywords = {name: changes[name] for name in sorted(changes, reverse=reverse)}
            assert gym.make(name, **keywords).unwrapped.params == Params.of(wanted, planar=name[-4] != "D")
        text = json.dumps(wanted.to_dict(), sort_keys=True)
        table = dict(sorted(json.loads(text).items(), reverse=reverse))
        table = {k: dict(sorted(v.items(), reverse=reverse)) if isinstance(v, dict) else v for k, v in table.items()}
        assert Params.from_dict(table) == wanted
        # Back to the defaults, likewise in any order.
        back = {name: DEFAULTS[name] for name in sorted({**changes, **IMPLIED}, reverse=reverse)}
        assert Params.of(wanted, **back) == Params()


IMPLIED = dict.fromkeys(RANGES_IMPLY)


def test_numbers_linked_within_a_group_are_all_in_the_list():
    """Whatever pair of a group's numbers can only be changed together is tried above."""
    tried = [set(changes) for changes in LINKED]
    for group in GROUPS.values():
        names = [f for f in dataclasses.fields(group) if "low" in f.metadata]
        for one, two in itertools.combinations(names, 2):
            for a, b in itertools.product(
                (one.metadata["low"], one.metadata["high"]), (two.metadata["low"], two.metadata["high"])
            ):
                if fine(group, **{one.name: a, two.name: b}) and not fine(group, **{one.name: a}):
                    assert any({one.name, two.name} <= names for names in tried), (one.name, two.name)


def fine(group, **changes):
    """Whether the group takes these changes of its defaults."""
    try:
        group(**changes)
    except ParamsError:
        return False
    return True


def test_ranges_imply_dead_reckoning_unless_told():
    assert Params.of(information="ranges").navigation.intruder == "dead-reckoning"
    assert Params.of(information="ranges").tracking.tracker == "bearings"
    assert Params.of(information="ranges", agent="gnss").navigation.agent == "gnss"
    assert Params.of(Params.of(information="ranges"), information="ranges", agent="gnss").navigation.agent == "gnss"


@given(st.integers(1, 100), st.floats(0.01, 0.1))
def test_ticks_per_decision(ticks, tick_s):
    assert Clock(tick_s=tick_s, decision_s=ticks * tick_s).ticks_per_decision == ticks


def test_derived_values():
    assert Clock().ticks_per_decision == 5
    aircraft = Aircraft(regulator_position_weight=4.0, regulator_velocity_weight=3.0, regulator_effort_weight=0.25)
    assert aircraft.position_gain_ps2 == math.sqrt(4.0 / 0.25)
    assert aircraft.velocity_gain_ps == math.sqrt(2.0 * 4.0 + 3.0 / 0.25)
    zone = Zone(range_error_m=2.0, range_error_probability=0.9, speed_relative_max_mps=7.0, reaction_s=0.5)
    assert zone.trials == 5
    assert zone.radius_m == pytest.approx((2.0 / 0.9 + 7.0 * 0.5) * 5, rel=1e-15)


def test_the_world_of_the_design():
    """The numbers of design section 2, once more by hand: a change here is a change of the benchmark."""
    p = Params()
    assert (p.clock.tick_s, p.clock.decision_s, p.clock.tail_min_s, p.clock.tail_max_s) == (0.1, 0.5, 15.0, 45.0)
    assert (p.aircraft.speed_max_mps, p.aircraft.vertical_speed_max_mps, p.aircraft.acceleration_max_mps2) == (5, 2, 2)
    assert p.aircraft.gust_mps == 0.2
    assert (p.encounter.cruise_min_mps, p.encounter.cruise_max_mps, p.encounter.closing_min_mps) == (2.0, 4.0, 1.5)
    assert (p.encounter.start_range_min, p.encounter.start_range_max, p.encounter.start_range_unit_m) == (1.1, 1.6, 120)
    assert (p.encounter.time_to_approach_max_s, p.encounter.horizontal_offset_m) == (75.0, 60.0)
    assert (p.encounter.vertical_offset_m, p.encounter.planar) == (20.0, True)
    assert (p.navigation.agent, p.navigation.intruder, p.navigation.node_square_m) == ("rss", "rss", 300.0)
    assert p.zone.radius_m == pytest.approx(120.0)
    assert p.zone.trials == 8
    assert (p.zone.collision_m, p.zone.snmac_horizontal_m, p.zone.snmac_vertical_m) == (4.5, 15.24, 4.57)
    assert (p.zone.warning_close_ratio, p.zone.warning_close_s, p.zone.hover_s) == (1.2, 2.0, 5.0)
    assert (p.interface.information, p.interface.action, p.tracking.tracker) == ("positions", "velocity", "fused")
    assert (p.messages.announce_s, p.messages.message_latency_s, p.messages.message_loss) == (5.0, 0.0, 0.0)
    reward = p.reward
    assert (reward.deviation_price, reward.snmac_price_m, reward.collision_price_m) == (1.0, 100.0, 10000.0)
    assert (reward.proximity_price_m, reward.comfort_m, reward.shaping_m) == (0.0, 35.0, 0.0)


def test_default_events_are_nested():
    zone = Zone()
    assert zone.collision_m <= zone.snmac_vertical_m <= zone.snmac_horizontal_m
    assert math.hypot(zone.snmac_horizontal_m, zone.snmac_vertical_m) < zone.radius_m


@pytest.mark.parametrize("name", sorted(CHANNELS))
def test_every_preset_loads_and_survives(name):
    channel = load_channel(name)
    assert load_channel(channel) is channel
    assert load_channel(channel.to_dict()) == channel
    assert load_channel(CHANNELS[name].source) == channel  # the same file by its path
    params = Params.of(channel=name)
    assert params.channels == (channel,)
    assert _through_json(params) == params
    assert channel.coloured_variance_db2 + channel.white_variance_db2 > 0.0


def test_presets_are_those_of_the_design():
    assert set(CHANNELS) == {"paper", "outdoor", "quadcopter", "wifi-walk", "ble-indoor", "clean"}
    rows = {
        "paper": (2.7, 0.1, 6.4, 0.15),
        "outdoor": (2.7, 4.0, 4.0, 2.0),
        "quadcopter": (3.3, 1.6, 20.9, 6.7),
        "wifi-walk": (2.5, 1.96, 10.0, 8.1),
        "ble-indoor": (1.7, 17.6, 7.5, 3.5),
    }
    for name, row in rows.items():
        c = load_channel(name)
        assert (c.path_loss_factor, c.white_variance_db2, c.coloured_variance_db2, c.coloured_tc_s) == row
    assert load_channel("outdoor") == Channel()
    assert load_channel("paper").path_loss_wander == 0.0


def test_several_channels():
    params = Params.of(channel=["paper", {"path_loss_factor": 3.0}, Channel(packet_loss=0.1)])
    assert [c.path_loss_factor for c in params.channels] == [2.7, 3.0, 2.7]
    assert params.channels[2].packet_loss == 0.1


def test_channel_file(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("[channel]\npath_loss_factor = 3.0\n", encoding="utf-8")
    assert Params.of(channel=str(file)).channels[0].path_loss_factor == 3.0
    for text, sentence in (
        ("[channel]\npath_loss_facto = 3.0\n", "did you mean 'path_loss_factor'"),
        ("[channel]\npath_loss_factor = 30.0\n", "path_loss_factor"),
        ("path_loss_factor = 3.0\n", "the file has no parameter .path_loss_factor.; known: channel"),
        ("[channel\n", "not readable TOML"),
    ):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(ParamsError, match=sentence):
            load_channel(file)
    with pytest.raises(ParamsError, match="does not exist"):
        load_channel(tmp_path / "none.toml")
    with pytest.raises(ParamsError, match="did you mean 'paper'"):
        load_channel("papr")


def test_families_are_normalised():
    assert Params.of(families=["crossing"]).encounter == Encounter(families="crossing")
    assert Params.of(families=["crossing", "turning"]).encounter == Encounter(families=("crossing", "turning"))
