"""Registries: names and parts that do not fit are refused in one sentence; parts travel to other processes."""

import dataclasses
import pickle
import subprocess
import sys

import pytest

import rss_gym
from rss_gym import extend, registry
from rss_gym.baselines import POLICIES
from rss_gym.baselines.policy import Nothing, Scripted
from rss_gym.encounters import FAMILIES
from rss_gym.encounters.family import Family
from rss_gym.eval.metrics import METRICS, Metric
from rss_gym.eval.suites import SUITES, Suite
from rss_gym.params import CHANNELS, Channel, Params, ParamsError

FAMILY = Family(summary="for the test", weight=0.0)


class Undocumented(Nothing):
    pass


@dataclasses.dataclass(frozen=True, kw_only=True)
class Idle(Scripted):
    """Has no method `act`."""


@pytest.fixture
def forget():
    """Removes afterwards what a test registers."""
    before = {kind: set(registry.of(kind)) for kind in registry.HOMES}
    yield
    for kind, names in before.items():
        for name in set(registry.of(kind)) - names:
            registry.of(kind).remove(name)


def test_every_registry_has_a_door_and_every_door_a_registry():
    doors = {name.removeprefix("register_") for name in rss_gym.__all__ if name.startswith("register_")}
    assert doors == set(registry.HOMES) == {name.removeprefix("register_") for name in extend.__all__}
    for kind in registry.HOMES:
        found = registry.of(kind)
        assert found.kind == kind and found.shipped and list(found) == list(found.shipped)


def test_a_part_is_found_and_can_be_taken_out_again(forget):
    rss_gym.register_channel("mine", Channel(path_loss_factor=2.0), "measured")
    assert Params.of(channel="mine").channels[0].path_loss_factor == 2.0
    assert CHANNELS["mine"].summary == "measured" and [*CHANNELS] == [*CHANNELS.shipped, "mine"]
    CHANNELS.remove("mine")
    with pytest.raises(ParamsError, match="channel preset 'mine' is unknown"):
        Params.of(channel="mine")
    with pytest.raises(ParamsError, match="channel 'paper' was not registered"):
        CHANNELS.remove("paper")


def test_worlds_of_the_package_do_not_change_when_parts_are_added(forget):
    radios, hashes = Params.of(channel="radios").channels, {name: suite.hash for name, suite in SUITES.items()}
    rss_gym.register_channel("mine", {}, "measured")
    rss_gym.register_family("mine", FAMILY)
    assert Params.of(channel="radios").channels == radios
    assert {name: suite.hash for name, suite in SUITES.items()} == hashes


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rss_gym.register_family("crossing", FAMILY), ["family 'crossing' is registered already"]),
        (lambda: rss_gym.register_family("My Family", FAMILY), ["'My Family'", "must look like 'my-family'"]),
        (lambda: rss_gym.register_family(3, FAMILY), ["family name 3"]),
        (lambda: rss_gym.register_family("mixed", FAMILY), ["'mixed' stands for all"]),
        (lambda: rss_gym.register_family("mine", {}), ["rss_gym.encounters.family.Family, got dict"]),
        (lambda: rss_gym.register_family("mine", dataclasses.replace(FAMILY, weight=1.0)), ["weight must be 0, got 1"]),
        (lambda: rss_gym.register_family("mine", dataclasses.replace(FAMILY, summary=" ")), ["have a summary"]),
        (lambda: rss_gym.register_channel("radios", {}, "x"), ["'radios' stands for all presets"]),
        (lambda: rss_gym.register_channel("mine", {}, " "), ["'mine' must have a summary"]),
        (lambda: rss_gym.register_channel("mine", {"gamma": 2}, "x"), ["no parameter 'gamma'"]),
        (lambda: rss_gym.register_rule("mine", Nothing()), ["frozen dataclass derived from", "got Nothing("]),
        (lambda: rss_gym.register_rule("mine", Idle), ["Idle must have a method act(seen, memory)"]),
        (lambda: rss_gym.register_rule("mine", Undocumented), ["Undocumented must have a docstring"]),
        (lambda: rss_gym.register_rule("orca", Nothing), ["rule 'orca' is registered already"]),
        (lambda: rss_gym.register_metric("mine", len), ["metric 'mine' must be a rss_gym.eval.metrics.Metric"]),
        (lambda: rss_gym.register_metric("my-metric", Metric("x", "1", len)), ["must look like 'my_metric_m'"]),
        (lambda: rss_gym.register_metric("mine", Metric("x", "1", None)), ["function must be callable, got None"]),
        (lambda: rss_gym.register_metric("mine", Metric("", "1", len)), ["summary must be a text, got ''"]),
        (lambda: rss_gym.register_metric("mine", Metric("x", "1", len, domains=("sea",))), ["domains must hold 'air'"]),
        (lambda: rss_gym.register_suite(Suite("mine", "x")), ["suite name 'mine' must look like 'my-suite-v0'"]),
        (lambda: rss_gym.register_suite({}), ["suite name ''"]),
        (lambda: rss_gym.register_suite(Suite("mine-v0", "")), ["must have a summary"]),
        (lambda: rss_gym.register_suite(Suite("mine-v0", "x", episodes=0)), ["episodes must be", "got 0"]),
        (lambda: rss_gym.register_suite(Suite("mine-v0", "x", split="test")), ["split 'test' is unknown"]),
        (lambda: registry.of("sensor"), ["registry 'sensor' is unknown"]),
    ],
)
def test_what_does_not_fit_is_refused_in_one_sentence(call, words):
    with pytest.raises(ParamsError) as caught:
        call()
    assert "\n" not in str(caught.value) and all(word in str(caught.value) for word in words), caught.value
    assert all(list(registry.of(kind)) == list(registry.of(kind).shipped) for kind in registry.HOMES)


def test_parts_travel_to_other_processes(forget):
    assert registry.added() == b""
    rss_gym.register_family("mine", FAMILY)
    rss_gym.register_rule("mine", Nothing)
    sent = registry.added()
    assert [(kind, name) for kind, name, _ in pickle.loads(sent)] == [("family", "mine"), ("rule", "mine")]
    registry.restore(sent)  # here they are there already
    FAMILIES.remove("mine")
    POLICIES.remove("mine")
    registry.restore.cache_clear()
    registry.restore(sent)
    assert FAMILIES["mine"] == FAMILY and POLICIES["mine"] is Nothing


def test_a_part_that_cannot_be_sent_is_named(forget):
    rss_gym.register_metric("mine", Metric("x", "1", lambda flights: None))
    with pytest.raises(ParamsError, match=r"metric 'mine' cannot be sent to worker processes .*define it in a module"):
        registry.added()
    assert "mine" in METRICS


def test_the_doors_load_nothing_heavy():
    code = "import sys, rss_gym\nrss_gym.register_channel('mine', {}, 'x')\n"
    code += "print(sorted({'numba', 'scipy'} & {*sys.modules}))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
