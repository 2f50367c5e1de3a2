"""The translated world scores as Python's does, bit by bit; `benchmarks/fly_equality.py` flies 1,000 encounters."""

import pytest

from rss_gym.errors import ParamsError
from rss_gym.eval.suites import find
from rss_gym.fly.engines import engines
from rss_gym.fly.equality import PILOTS, compare


@pytest.mark.parametrize("pilot", PILOTS)
@pytest.mark.parametrize("engine", ["node", pytest.param("chromium", marks=pytest.mark.slow)])
def test_twenty_encounters_score_the_same(engine, pilot):
    if engine not in engines():
        pytest.skip(f"{engine} is not on the path")
    comparison = compare(find("encounter-v0"), "pathwise-plane", range(20), engine, pilot)
    assert comparison.equal == 20, comparison.summary
    assert not any(comparison.largest.values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suite", "agent"), [("encounter3d-v0", "pathwise-space"), ("range-only-v0", "ppo-range"), ("gnss-v0", "ppo-plane")]
)
def test_other_worlds_too(suite, agent):
    if not engines():
        pytest.skip("neither node nor chromium is on the path")
    comparison = compare(find(suite), agent, range(20), next(iter(engines())))
    assert comparison.equal == 20, comparison.summary


def test_a_suite_of_roads_is_refused():
    from rss_gym.baselines.agent import load
    from rss_gym.baselines.shipped import AGENTS
    from rss_gym.fly.world import program

    with pytest.raises(ParamsError, match="flown on roads"):
        program(find("highway-v0"), load(AGENTS["pathwise-plane"]))
