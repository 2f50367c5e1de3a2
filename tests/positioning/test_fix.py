"""The general fix (1): exact cases, SciPy's least squares, Monte Carlo, mirrors and degenerate nodes."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from rss_gym.params import ParamsError
from rss_gym.positioning.fix import fix
from rss_gym.positioning.trilateration import trilaterate

SHAPES = [(3, 2), (4, 2), (6, 2), (3, 3), (4, 3), (6, 3)]


def ranges_of(nodes, position):
    return np.linalg.norm(nodes - position[..., None, :], axis=-1)


@pytest.mark.parametrize(("count", "axes"), SHAPES)
def test_exact_without_noise(count, axes):
    """1,000 random sets of nodes: the truth comes back, or as the mirror where the prior, 1 cm off, is nearer to it."""
    rng = np.random.default_rng(1)
    nodes, position = rng.uniform(-100.0, 100.0, (1000, count, axes)), rng.uniform(-100.0, 100.0, (1000, axes))
    got = fix(nodes, ranges_of(nodes, position), 1e-6, prior_m=position + 0.01 / np.sqrt(axes))
    error = np.linalg.norm(got.position_m - position, axis=1)
    mirror_error = np.linalg.norm(got.mirror_m - position, axis=1)
    clear = got.condition < 100.0
    assert clear.mean() > 0.9
    assert (np.fmin(error, mirror_error)[clear] < 1e-9).all()
    assert (error[clear] < 1e-9).mean() > 0.999
    assert np.abs(got.residual_m).max() < 1e-5
    assert got.ambiguous.all() if count == axes else not got.ambiguous.any()  # three nodes always share a plane


@pytest.mark.slow
@pytest.mark.parametrize(("count", "axes"), SHAPES)
def test_least_squares_of_scipy(count, axes):
    """30 noisy fixes with unequal weights: no start of SciPy's solver, out of ten, finds a smaller misfit."""
    rng = np.random.default_rng(2)
    for _ in range(30):
        nodes, position = rng.uniform(-100.0, 100.0, (count, axes)), rng.uniform(-100.0, 100.0, axes)
        std, node_std = rng.uniform(0.5, 8.0, count), rng.uniform(0.0, 5.0, count)
        total = np.hypot(std, node_std)
        ranges = np.abs(ranges_of(nodes, position) + total * rng.standard_normal(count))
        got = fix(nodes, ranges, std, node_std)

        def residuals(x, nodes=nodes, ranges=ranges, total=total):
            return (ranges_of(nodes, x) - ranges) / total

        starts = rng.uniform(-150.0, 150.0, (10, axes))
        tight = {"xtol": 1e-13, "ftol": 1e-13, "gtol": 1e-13}
        best = min((least_squares(residuals, start, **tight) for start in starts), key=lambda found: found.cost)
        assert np.sum(residuals(got.position_m) ** 2) <= 2.0 * best.cost * (1.0 + 1e-6) + 1e-9
        near = least_squares(residuals, got.position_m, **tight)
        assert got.degenerate or got.position_m == pytest.approx(near.x, abs=1e-4)
        if not got.degenerate:
            jacobian = near.jac
            assert got.covariance_m2 == pytest.approx(np.linalg.inv(jacobian.T @ jacobian), rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("axes", [2, 3])
def test_covariance_is_the_scatter(axes):
    """4,000 fixes with errors of ranges and nodes: the sample covariance, to five standard errors and 3 %."""
    rng = np.random.default_rng(3)
    nodes = rng.uniform(-100.0, 100.0, (6, axes))
    position = np.array([20.0, -30.0, 40.0])[:axes]
    std, node_std = np.array([0.3, 0.5, 0.4, 1.0, 0.3, 0.6]), np.array([0.0, 0.5, 0.0, 0.2, 0.3, 0.0])
    count = 4000
    wrong_nodes = nodes + node_std[:, None] * rng.standard_normal((count, 6, axes))
    ranges = ranges_of(nodes, position) + std * rng.standard_normal((count, 6))
    got = fix(wrong_nodes, ranges, std, node_std, prior_m=position)
    stated = fix(nodes, ranges_of(nodes, position), std, node_std, prior_m=position).covariance_m2
    sample = np.cov(got.position_m.T)
    diagonal = np.diag(stated)
    standard_error = np.sqrt((np.outer(diagonal, diagonal) + stated**2) / count)
    assert (np.abs(sample - stated) < 5.0 * standard_error + 0.03 * np.sqrt(np.outer(diagonal, diagonal))).all()
    # Normalised squared errors average to the number of coordinates.
    error = got.position_m - position
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(got.covariance_m2), error)
    assert nees.mean() == pytest.approx(axes, rel=0.1)


def test_dilution_and_condition_of_a_square():
    """From the middle of a square the directions are (+-1, +-1)/sqrt 2: H^T H = 2 I, so GDOP 1 and condition 1."""
    nodes = np.array([[50.0, 50.0], [-50.0, 50.0], [-50.0, -50.0], [50.0, -50.0]])
    got = fix(nodes, np.full(4, 50.0 * np.sqrt(2.0)), 3.0, 4.0)
    assert got.dilution == pytest.approx(1.0)
    assert got.condition == pytest.approx(1.0)
    assert got.covariance_m2 == pytest.approx(12.5 * np.eye(2))  # (3^2 + 4^2) / 2
    assert not got.ambiguous and not got.degenerate


@pytest.mark.slow
@given(st.floats(-80.0, 80.0), st.floats(-80.0, 80.0), st.floats(1.0, 120.0), st.integers(3, 5))
def test_coplanar_nodes_leave_a_mirror(x, y, height, count):
    nodes = np.array([[60.0, 0.0, 5.0], [-40.0, 50.0, 5.0], [-30.0, -60.0, 5.0], [70.0, 70.0, 5.0], [0.0, 9.0, 5.0]])
    nodes, above, below = nodes[:count], np.array([x, y, 5.0 + height]), np.array([x, y, 5.0 - height])
    ranges = ranges_of(nodes, above)
    free, low = fix(nodes, ranges), fix(nodes, ranges, prior_m=below + 0.2 * height)
    assert free.ambiguous and low.ambiguous
    assert free.position_m == pytest.approx(above, abs=1e-4) and free.mirror_m == pytest.approx(below, abs=1e-4)
    assert low.position_m == pytest.approx(below, abs=1e-4) and low.mirror_m == pytest.approx(above, abs=1e-4)


def test_nodes_on_a_line_leave_a_mirror_in_the_plane():
    nodes, position = np.array([[0.0, 0.0], [50.0, 0.0], [120.0, 0.0]]), np.array([30.0, -40.0])
    got = fix(nodes, ranges_of(nodes, position), prior_m=(30.0, -10.0))
    assert got.position_m == pytest.approx(position) and got.mirror_m == pytest.approx([30.0, 40.0])


def test_position_in_the_plane_of_the_nodes_is_flagged():
    nodes = np.array([[60.0, 0.0, 5.0], [-40.0, 50.0, 5.0], [-30.0, -60.0, 5.0]])
    position = np.array([10.0, 5.0, 5.0])
    got = fix(nodes, ranges_of(nodes, position))
    assert got.degenerate and np.isfinite(got.covariance_m2).all()
    assert got.position_m == pytest.approx(position, abs=1e-3)
    assert got.covariance_m2[2, 2] > 1e6  # nothing holds the height
    # Spheres that do not meet: the nearest point lies in the plane, as SciPy's solver finds.
    short = fix(nodes, ranges_of(nodes, position) - 3.0)
    assert short.degenerate and short.position_m[2] == pytest.approx(5.0, abs=1e-3)
    best = least_squares(
        lambda xy: ranges_of(nodes, np.array([*xy, 5.0])) + 3.0 - ranges_of(nodes, position), (0.0, 0.0)
    )
    assert short.position_m[:2] == pytest.approx(best.x, abs=1e-3)


def test_strongest_three_are_the_nearest():
    rng = np.random.default_rng(4)
    nodes, position = rng.uniform(-100.0, 100.0, (50, 6, 2)), rng.uniform(-50.0, 50.0, (50, 2))
    ranges = ranges_of(nodes, position) * (1.0 + 0.05 * rng.standard_normal((50, 6)))
    std = 0.05 * ranges
    got = fix(nodes, ranges, std, strongest=3, prior_m=position)
    for n in range(50):
        nearest = np.sort(np.argsort(ranges[n])[:3])
        alone = fix(nodes[n, nearest], ranges[n, nearest], std[n, nearest], prior_m=position[n])
        assert got.position_m[n] == pytest.approx(alone.position_m, abs=1e-6)
        assert got.residual_m[n, nearest] == pytest.approx(alone.residual_m, abs=1e-6)
    assert got.residual_m.shape == (50, 6)


@pytest.mark.slow
@given(st.permutations(range(5)), st.integers(2, 3), st.integers(0, 2**32 - 1))
def test_order_of_the_nodes_does_not_matter(order, axes, seed):
    rng = np.random.default_rng(seed)
    nodes, position = rng.uniform(-100.0, 100.0, (5, axes)), rng.uniform(-50.0, 50.0, axes)
    ranges, std = ranges_of(nodes, position) + rng.uniform(-0.5, 0.5, 5), rng.uniform(0.5, 2.0, 5)
    one = fix(nodes, ranges, std, prior_m=position)
    assume(one.condition < 30.0 and not one.ambiguous)
    other = fix(nodes[order], ranges[order], std[order], prior_m=position)
    assert other.position_m == pytest.approx(one.position_m, abs=1e-5)
    assert other.covariance_m2 == pytest.approx(one.covariance_m2, rel=1e-5, abs=1e-8)
    assert other.residual_m == pytest.approx(one.residual_m[order], abs=1e-5)


def test_moving_nodes_are_one_epoch_at_a_time():
    rng = np.random.default_rng(5)
    nodes, position = rng.uniform(-100.0, 100.0, (20, 4, 3)), rng.uniform(-50.0, 50.0, (20, 3))
    ranges, std = ranges_of(nodes, position) + rng.standard_normal((20, 4)), rng.uniform(0.5, 2.0, (20, 4))
    got = fix(nodes, ranges, std, prior_m=position)
    for n in range(20):
        one = fix(nodes[n], ranges[n], std[n], prior_m=position[n])
        assert one.position_m == pytest.approx(got.position_m[n], abs=1e-5)
        assert one.position_m.shape == (3,) and one.dilution.shape == ()
        assert bool(one.ambiguous) == bool(got.ambiguous[n])
    still = fix(nodes[0], ranges_of(nodes[0], position), prior_m=position)  # one set of nodes, many epochs
    assert still.position_m == pytest.approx(position, abs=1e-5)


@pytest.mark.slow
@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_agrees_with_the_worlds_kernel(x, y):
    """In the nodes' horizontal plane, three ranges 1-2 m wrong: the kernel after 30 steps finds the same minimum."""
    nodes = np.array([[60.0, 0.0], [-40.0, 50.0], [-30.0, -60.0]])
    ranges = ranges_of(nodes, np.array([x, y])) + np.array([1.0, 2.0, 1.5])
    assume(ranges.min() > 5.0)
    flat = tuple(np.append(node, 0.0) for node in nodes)
    kernel_x, kernel_y, std_m = trilaterate(flat, tuple(ranges), (1.0, 4.0, 2.25), 0.0, 30)
    got = fix(nodes, ranges, (1.0, 2.0, 1.5))
    assert got.position_m == pytest.approx((kernel_x, kernel_y), abs=1e-3)
    assert np.sqrt(0.5 * np.trace(got.covariance_m2)) == pytest.approx(std_m, rel=0.02)  # the kernel's is damped


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: fix([[0, 0], [1, 0]], [1, 1]), "three or more nodes, got 2 ranges and 2 nodes"),
        (lambda: fix(np.eye(3), [1, 1]), "got 2 ranges and 3 nodes"),
        (lambda: fix(np.zeros((3, 4)), [1, 1, 1]), "nodes_m must have the shape"),
        (lambda: fix(np.eye(3), [1, np.nan, 1]), "ranges_m must be finite in .*, got nan"),
        (lambda: fix(np.eye(3), [1, -1, 1]), "ranges_m must be finite in .*, got -1"),
        (lambda: fix(np.eye(3), [1, 1, 1], 0.0), "range_std_m must be finite"),
        (lambda: fix(np.eye(3), [1, 1, 1], [1.0, 2.0]), "range_std_m and node_std_m must fit the shape"),
        (lambda: fix(np.eye(3), [1, 1, 1], prior_m=[0.0, 0.0]), "prior_m must fit the shape"),
        (lambda: fix(np.eye(3), [1, 1, 1], strongest=2), "strongest must be a whole number from 3 to the 3 nodes"),
        (lambda: fix(np.ones((2, 3, 2)), np.ones((2, 3))), "must not all lie at one point, as they do at epoch 0"),
        (lambda: fix([[0, 0, 0], [1, 1, 1], [3, 3, 3]], [1, 1, 1]), "must not all lie on one line"),
    ],
)
def test_bad_input_is_one_sentence(call, words):
    with pytest.raises(ParamsError, match=words):
        call()


def test_the_package_gives_the_functions_not_the_modules_of_their_names():
    import importlib
    import pkgutil

    import rss_gym

    hidden = []
    for library in ("avoidance", "positioning", "radio", "ranging", "safety"):
        package = importlib.import_module(f"rss_gym.{library}")
        for module in pkgutil.iter_modules(package.__path__):
            found = importlib.import_module(f"rss_gym.{library}.{module.name}")
            if callable(getattr(found, module.name, None)) and not callable(getattr(package, module.name)):
                hidden.append(f"{library}.{module.name}")
    assert hidden == [] and rss_gym
