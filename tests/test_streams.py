"""The registry of noise streams: none overlap, and every draw of the package belongs to one."""

import ast
import itertools
from pathlib import Path

import pytest

import rss_gym
from rss_gym import streams
from rss_gym.params import Params
from rss_gym.state import config, global_link, normal_streams, used_links
from rss_gym.streams import STREAMS

PACKAGE = Path(rss_gym.__file__).parent


def test_no_two_streams_overlap():
    ranges = {name: range(s.start, s.start + s.width) for name, s in STREAMS.items()}
    for one, two in itertools.combinations(ranges, 2):
        assert max(ranges[one][0], ranges[two][0]) > min(ranges[one][-1], ranges[two][-1]), (one, two)
    assert all(s.width >= 1 and s.meaning for s in STREAMS.values())


def test_every_constant_is_in_the_registry():
    constants = {name: value for name, value in vars(streams).items() if name.startswith("STREAM_")}
    named = {f"STREAM_{name.upper().replace('-', '_')}": s.start for name, s in STREAMS.items()}
    assert constants == named


def test_no_module_has_a_stream_of_its_own():
    """A constant of that name is assigned in the registry alone, and streams of draws are made of the constants."""
    for path in PACKAGE.rglob("*.py"):
        if path == Path(streams.__file__):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            assert not any(name.startswith("STREAM_") for name in names), (path.name, names)


def test_the_sampled_decision_has_its_own():
    """And no complication of any intruder shares it."""
    from rss_gym.eval import episodes

    assert episodes.STREAM_SAMPLE == STREAMS["sample"].start


@pytest.mark.parametrize("planar", [True, False])
def test_streams_of_ticks_and_decisions_are_within_their_ranges(planar):
    params = Params.of(intruders=streams.MAX_INTRUDERS, planar=planar)
    tick, decision = normal_streams(params, used_links(params))

    def owners(numbers):
        return {name for number in numbers for name, s in STREAMS.items() if s.start <= number < s.start + s.width}

    assert owners(tick) == {"tick"}
    assert owners(decision) <= {"wander", "aircraft"}
    assert len(set(tick)) == len(tick) and len(set(decision)) == len(decision)
    last = global_link(streams.MAX_INTRUDERS, len(used_links(params)) - 1)
    assert last == streams.LINKS - 1
    assert config(params)[0]["intruders"] == streams.MAX_INTRUDERS
