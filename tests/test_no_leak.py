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
