"""ORCA and its linear program: equal to the library RVO2, and optimal whatever the half-planes."""

import numpy as np
import pyrvo
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.avoidance.half_planes import nearest_velocity, put_plane
from rss_gym.avoidance.orca import half_plane

PERIOD_S, SPEED_MPS = 0.5, 5.0
AT_REST = np.zeros(2)


def half_planes(others, own, radius_m, lookahead_s, responsibility=0.5):
    """Rows of ORCA^tau; `others` are pairs of relative position and velocity."""
    planes = np.zeros((len(others), 4))
    for n, ((x, y), (vx, vy)) in enumerate(others):
        relative = own[0] - vx, own[1] - vy
        half_plane(x, y, *relative, *own, radius_m, lookahead_s, PERIOD_S, responsibility, planes, n)
    return planes


def library(others, own, preferred, radius_m, lookahead_s):
    simulator = pyrvo.RVOSimulator(PERIOD_S, 1e4, 10, lookahead_s, lookahead_s, 0.5 * radius_m, SPEED_MPS)
    for position, velocity in [(AT_REST, own), *others]:
        agent = simulator.add_agent([float(value) for value in position])
        simulator.set_agent_velocity(agent, [float(value) for value in velocity])
        simulator.set_agent_pref_velocity(agent, [float(value) for value in preferred])
    simulator.do_step()
    chosen = simulator.get_agent_velocity(0)
    return np.array([chosen.x, chosen.y])


def outside(planes, velocity):
    """How far a velocity is outside the worst half-plane, m/s; negative inside all."""
    to_point = planes[:, :2] - velocity
    return (planes[:, 2] * to_point[:, 1] - planes[:, 3] * to_point[:, 0]).max()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_equals_the_library(count):
    """Within 1e-5 but where its single precision meets nearly parallel edges; there ours is no worse by definition."""
    generator = np.random.default_rng(count)
    gaps = []
    for _ in range(2000):
        others = [(generator.uniform(-120, 120, 2), generator.uniform(-3.5, 3.5, 2)) for _ in range(count)]
        own, preferred = generator.uniform(-3.5, 3.5, (2, 2))
        radius_m, lookahead_s = generator.uniform(5, 60), generator.uniform(2, 30)
        planes = half_planes(others, own, radius_m, lookahead_s)
        ours = nearest_velocity(planes, SPEED_MPS, preferred)
        theirs = library(others, own, preferred, radius_m, lookahead_s)
        gaps.append(np.abs(ours - theirs).max())
        assert np.hypot(*ours) <= SPEED_MPS + 1e-9
        assert outside(planes, ours) <= max(outside(planes, theirs), 0.0) + 3e-5
        if outside(planes, theirs) <= 0.0:
            assert np.hypot(*(ours - preferred)) <= np.hypot(*(theirs - preferred)) + 1e-5
    assert np.mean(np.array(gaps) <= 1e-5) >= 0.99
    assert np.median(gaps) <= 1e-6


angle = st.floats(0.0, 2.0 * np.pi)
speed = st.floats(-4.0, 4.0)


@pytest.mark.slow
@given(st.lists(st.tuples(speed, speed, angle), max_size=6), st.tuples(speed, speed))
def test_no_sampled_velocity_is_better(edges, preferred):
    planes = np.zeros((len(edges), 4))
    for n, (x, y, heading) in enumerate(edges):
        put_plane(planes, n, x, y, np.cos(heading), np.sin(heading))
    chosen = nearest_velocity(planes, SPEED_MPS, preferred)
    assert np.hypot(*chosen) <= SPEED_MPS + 1e-6
    grid = np.stack(np.meshgrid(np.linspace(-5, 5, 81), np.linspace(-5, 5, 81)), axis=-1).reshape(-1, 2)
    grid = grid[np.hypot(*grid.T) <= SPEED_MPS]
    worst = np.array([outside(planes, point) for point in grid]) if edges else np.full(len(grid), -1.0)
    mine = outside(planes, chosen) if edges else -1.0
    assert mine <= max(worst.min(), 0.0) + 1e-4
    if (worst <= 0.0).any():
        distance = np.hypot(*(grid[worst <= 0.0] - preferred).T).min()
        assert np.hypot(*(chosen - preferred)) <= distance + 1e-4


def test_at_full_responsibility_the_pair_passes_at_the_radius():
    """The other flies on: ORCA's velocity, held, keeps the distance that half the change would not."""
    others, own = [((60.0, 4.0), (-3.0, 0.0))], np.array([3.0, 0.0])
    separation = {}
    for responsibility in (0.5, 1.0):
        chosen = nearest_velocity(half_planes(others, own, 20.0, 30.0, responsibility), SPEED_MPS, own)
        times = np.linspace(0.0, 30.0, 3001)[:, None]
        path = np.array(others[0][0]) + (np.array(others[0][1]) - chosen) * times
        separation[responsibility] = np.hypot(*path.T).min()
    assert separation[1.0] == pytest.approx(20.0, abs=0.3)
    assert separation[0.5] < 16.0
