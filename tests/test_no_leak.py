"""The observation is written from `Sensed` alone, and `Sensed` from what an agent may know."""

import ast
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rss_gym
from rss_gym.core import Batch
from rss_gym.observation import fields, write
from rss_gym.params import Params
from rss_gym.sensed import OTHER, OWN
from rss_gym.sensing import sense_row

PACKAGE = Path(rss_gym.__file__).parent


# -- observation.write against the table ------------------------------------------------------------------------------


def _axes(along):
    """Along, right and up of a leg."""
    return np.array([along, [along[1], -along[0], 0.0], [0.0, 0.0, 1.0]])


def expected(own, others):
    """Value in SI units of every field, by name, with a formula of its own (one leg axis at a time)."""
    axes = _axes(own["along"])
    turned = axes @ own["turn_along"]
    values = {
        "cruise_mps": own["planned_mps"] @ own["along"],
        "time_s": own["time_s"],
        "turn_in_s": own["turn_in_s"],
        "turn_cos": turned[0],
        "turn_sin": turned[1],
    }
    vectors = {
        "track_error_{}_m": own["position_m"] - own["planned_m"],
        "way_point_{}_m": own["way_point_m"] - own["planned_m"],
        "velocity_{}_mps": own["velocity_mps"],
    }
    for k, other in enumerate(others):
        prefix, present = f"intruder_{k}.", bool(other["present"])
        heard = present and bool(other["valid"])
        scalars = {
            "present": 1.0,
            "range_m": other["range_m"],
            "range_std_m": other["range_std_m"],
            "coloured_db": other["coloured_db"],
            "path_loss_factor": other["path_loss_factor"],
            "range_rate_mps": other["range_rate_mps"],
            "zone_radius_m": other["radius_m"],
            "margin_m": other["range_m"] - other["radius_m"],
            "warning": float(other["warning"]),
            "streak": other["streak"],
            "message_valid": float(other["valid"]),
        }
        values |= {prefix + name: value if present else 0.0 for name, value in scalars.items()}
        values[prefix + "message_age_s"] = other["age_s"] if heard else 0.0
        for name, vector in {
            "message_velocity_{}_mps": other["velocity_mps"],
            "message_position_{}_m": other["position_m"] - own["position_m"],
            "message_way_point_{}_m": other["way_point_m"] - own["position_m"],
        }.items():
            vectors[prefix + name] = vector if heard else np.zeros(3)
    for name, vector in vectors.items():
        for axis, component in zip(("along", "right", "up"), axes @ vector, strict=True):
            values[name.format(axis)] = component
    return values


def sensed(generator, k, wild):
    """Records filled with random numbers, far outside the limits if `wild`."""
    own, others = np.zeros(1, OWN)[0], np.zeros(k, OTHER)
    scale = 10.0 ** generator.uniform(-3, 5) if wild else 30.0
    for record in (own, *others):
        for name in record.dtype.names:
            if record.dtype[name].kind == "b":
                record[name] = generator.random() < 0.7
            else:
                record[name] = scale * generator.normal(size=record.dtype[name].shape)
    headings = generator.uniform(-np.pi, np.pi, 2)
    for name, heading in zip(("along", "turn_along"), headings, strict=True):
        own[name] = np.cos(heading), np.sin(heading), 0.0
    own["time_s"] = generator.uniform(0.0, 200.0)
    own["turn_in_s"] = np.inf if generator.random() < 0.3 else abs(own["turn_in_s"])
    for other in others:
        other["streak"] = generator.uniform(0.0, 1.0)
        other["age_s"], other["range_m"] = abs(other["age_s"]), abs(other["range_m"])
    return own, others


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("track", ["oracle", "paper", "range"])
@pytest.mark.parametrize("k", [1, 3, 8])
@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), wild=st.booleans())
def test_every_column_is_its_field(planar, track, k, seed, wild):
    own, others = sensed(np.random.default_rng(seed), k, wild)
    table = fields(Params.of(planar=planar, track=track, intruders=k))
    out = np.full(len(table), np.nan, np.float32)
    # Records of an array: a NumPy scalar record would be a copy.
    owns = np.array([own], OWN)
    write(owns[0], others, planar, track != "range", out)
    values = expected(own, others)
    for column, f in enumerate(table):
        scaled = np.clip(values[f.name] / f.scale, f.low, f.high)
        assert out[column] == pytest.approx(scaled, rel=1e-6, abs=1e-6), f.name
        assert np.float32(f.low) <= out[column] <= np.float32(f.high)


def test_write_does_not_change_what_was_sensed():
    own, others = sensed(np.random.default_rng(0), 2, False)
    owns = np.array([own], OWN)
    before = owns.tobytes(), others.tobytes()
    write(owns[0], others, False, True, np.zeros(len(fields(Params.of(planar=False, intruders=2))), np.float32))
    assert (owns.tobytes(), others.tobytes()) == before


# -- sensing: nothing true gets in ------------------------------------------------------------------------------------

# What `Sensed` may be made from. Everything else of the world, intruders' aircraft altogether, is the truth.
KNOWN = {
    "episode": {"tick", "channel", "intruders"},
    "aircraft": {  # the agent's own: its solution, and the trajectory it was given
        "solution_m", "solution_mps", "planned_m", "planned_mps", "along", "way_point_m",
        "path_m", "path_s", "path_points", "leg",
    },
    "links": {"range_m", "p_dd", "coloured_hat_db", "rate_mps"},  # of the agent's links to intruders
    "contacts": {"radius_m", "warning", "streak", "valid", "age_s", "position_m", "velocity_mps", "way_point_m"},
}  # fmt: skip


def _scramble(records, names, generator):
    for name in names:
        part = records[name]
        if part.dtype == bool:
            records[name] = generator.random(part.shape) < 0.5
        elif part.dtype.kind == "f":
            records[name] = part + generator.uniform(-50.0, 50.0, part.shape)
        else:
            records[name] = generator.integers(0, 2, part.shape)


def scramble_truth(world, generator):
    """Put noise on everything that is not in `KNOWN`."""
    k = world.contacts.shape[1]
    agents, intruders, to_nodes = world.aircraft[:, 0], world.aircraft[:, 1:], world.links[:, k:]
    for key, records in (
        ("episode", world.episode),
        ("aircraft", agents),
        ("links", world.links[:, :k]),
        ("contacts", world.contacts),
    ):
        _scramble(records, set(records.dtype.names) - KNOWN[key], generator)
    _scramble(intruders, intruders.dtype.names, generator)
    _scramble(to_nodes, to_nodes.dtype.names, generator)
    world.tick_normals[:] = generator.normal(size=world.tick_normals.shape)
    world.decision_normals[:] = generator.normal(size=world.decision_normals.shape)


def observe(batch):
    """Sense and write the rows anew."""
    params, out = batch.params, np.zeros_like(batch.observations)
    for i in range(batch.n):
        sense_row(batch.world, i, batch.own[i], batch.others[i])
        write(batch.own[i], batch.others[i], params.encounter.planar, params.interface.track != "range", out[i])
    return out


def flown(decisions=60, n=8, **keywords):
    """A batch in mid-flight."""
    batch = Batch(Params.of(**keywords), n)
    batch.seed(np.arange(n, dtype=np.uint64))
    batch.reset(np.ones(n, bool))
    generator = np.random.default_rng(0)
    for _ in range(decisions):
        ended = batch.episode["terminated"] | batch.episode["truncated"]
        batch.step(generator.uniform(-1, 1, (n, 3)), ended)
    return batch


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize(
    ("track", "localisation"),
    [("paper", "gnss"), ("paper", "rss"), ("paper", "dead-reckoning"), ("range", "gnss"), ("range", "dead-reckoning")],
)
def test_the_truth_does_not_reach_the_observation(planar, localisation, track):
    batch = flown(20, 16, track=track, planar=planar, agent=localisation, intruder=localisation, intruders=2)
    before = observe(batch)
    np.testing.assert_array_equal(before, batch.observations)
    assert batch.others["valid"].any() and not batch.others["valid"].all()
    for seed in range(10):
        scramble_truth(batch.world, np.random.default_rng(seed))
        assert observe(batch).tobytes() == before.tobytes()


def test_the_truth_reaches_track_oracle():
    """The scrambling does bite, and `oracle` is what it says."""
    batch = flown(track="oracle")
    before = observe(batch)
    scramble_truth(batch.world, np.random.default_rng(0))
    columns = [f.name for f in fields(batch.params)]
    changed = (observe(batch) != before).any(axis=0)
    for name in ("track_error_along_m", "intruder_0.range_m", "intruder_0.message_position_right_m"):
        assert changed[columns.index(name)]


def test_every_known_column_is_used():
    """`KNOWN` allows nothing that is not needed: changing any of it is seen."""
    for key, names in KNOWN.items():
        for name in names - {"path_points", "leg", "path_m", "path_s", "intruders", "channel", "warning", "valid"}:
            batch = flown(families="turning", decisions=40)
            before = observe(batch)
            records = getattr(batch.world, key)
            part = records[:, 0] if key == "aircraft" else records[:, :1] if key == "links" else records
            part[name] = part[name] + (7 if part[name].dtype.kind == "i" else 0.7)
            assert (observe(batch) != before).any(), (key, name)


@pytest.mark.parametrize("track", ["paper", "range"])
def test_position_is_withheld_until_it_is_sent(track):
    """Before the first message nothing about the intruder but its radio; on track `range` never a position."""
    batch = flown(decisions=0, track=track, n=64)
    silent = ~batch.others["valid"][:, 0]
    assert silent.sum() > 10
    columns = [f.name for f in fields(batch.params)]
    messages = [i for i, name in enumerate(columns) if ".message_" in name]
    assert (batch.observations[silent][:, messages] == 0).all()
    assert any("message_position" in name for name in columns) == (track == "paper")
    batch = flown(decisions=70, track=track, n=64)
    if track == "range":
        assert (batch.world.contacts["position_m"] == 0).all()
        assert (batch.others["position_m"] == 0).all()


# -- structure --------------------------------------------------------------------------------------------------------


def imported(module):
    """Modules of the package that `module` imports, with those that these import, from the source."""
    found, queue = set(), [module]
    while queue:
        name = queue.pop()
        path = PACKAGE.joinpath(*name.split(".")[1:])
        source = path.with_suffix(".py") if path.with_suffix(".py").is_file() else path / "__init__.py"
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            else:
                continue
            for other in names:
                path = PACKAGE.joinpath(*other.split(".")[1:])
                is_module = path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()
                if other.split(".")[0] == "rss_gym" and is_module and other not in found:
                    found.add(other)
                    queue.append(other)
    return found


def test_observation_does_not_import_the_world():
    truth = {f"rss_gym.{name}" for name in ("world", "records", "sensing", "core", "env", "vector", "encounters")}
    assert not imported("rss_gym.observation") & truth
    assert not imported("rss_gym.sensed")
    # The search itself finds what is there.
    assert {"rss_gym.params", "rss_gym.jit", "rss_gym.physics.motion"} <= imported("rss_gym.observation")
    assert truth - {"rss_gym.env", "rss_gym.vector", "rss_gym.core"} <= imported("rss_gym.core")
