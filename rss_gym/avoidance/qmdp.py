"""QMDP: value iteration for one intruder whose miss is known, flown on a belief of the miss.

Straight flight of both leads to a miss m, signed, along a unit vector n across the relative velocity, in a time t. The
own aircraft can displace its way point by w along n, so that the separation at the closest approach is |m - w|. The
table holds the least expected cost V(t, w, m): backwards from t = 0,

    V(0, w, m) = price(|m - w|) + w^2 / (2 u T)
    V(t, w, m) = min over u' in [-u, u] of |w'| dt / T + E V(t - dt, w', m + t a e),    w' = w + u' dt

with T the length of a flight, u the speed across the path, a the noise of the other's velocity in m/s over dt, and e
a standard normal number. Littman, Cassandra and Kaelbling (1995) take the mean of V over the belief for the value of
an action, as if the state were known from the next step on. That is optimistic, but it is exact where waiting tells all.
"""

from math import erf, floor, sqrt

import numpy as np

from rss_gym.jit import kernel

ACTIONS = 9  # speeds across the path in [-u, u]
# Points and weights of Gauss and Hermite for the mean over a normal distribution.
NODES = np.array([0.0, 1.1544053947399682, -1.1544053947399682, 2.3667594107345416, -2.3667594107345416,
                  3.7504397177257425, -3.7504397177257425])  # fmt: skip
WEIGHTS = np.array([0.45714285714285714, 0.2401231786050126, 0.2401231786050126, 0.030757123967586491,
                    0.030757123967586491, 0.00054826885597221841, 0.00054826885597221841])  # fmt: skip


@kernel(inline="always")
def between(table, x, y):
    """Bilinear interpolation of `table` at the indices x, y, held at its edges."""
    x, y = min(max(x, 0.0), table.shape[0] - 1.0), min(max(y, 0.0), table.shape[1] - 1.0)
    i, j = min(int(floor(x)), table.shape[0] - 2), min(int(floor(y)), table.shape[1] - 2)
    p, q = x - i, y - j
    low = (1.0 - q) * table[i, j] + q * table[i, j + 1]
    high = (1.0 - q) * table[i + 1, j] + q * table[i + 1, j + 1]
    return (1.0 - p) * low + p * high


@kernel
def solve(prices_m, limits_m, speed_mps, drift_mps, std_m, flight_s, step_s, steps, half_m, cell_m):
    """The table V (1 + steps, cells, cells), m: by time in steps of `step_s`, then w and m in [-half_m, half_m].

    Parameters
    ----------
    prices_m, limits_m : (2,) array
        Of an sNMAC and a collision: what they cost, and the separations below which they happen.
    speed_mps, noise_mps, flight_s : float
        u, a and T.
    step_s, steps, half_m, cell_m
        The grid.
    """
    cells = 1 + 2 * int(round(half_m / cell_m))
    table = np.empty((1 + steps, cells, cells))
    for i in range(cells):
        w = i * cell_m - half_m
        for j in range(cells):
            miss = j * cell_m - half_m - w
            value = w * w / (2.0 * speed_mps * flight_s)
            for event in range(2):
                low, high = -limits_m[event] - miss, limits_m[event] - miss
                value += 0.5 * prices_m[event] * (erf(high / (sqrt(2.0) * std_m)) - erf(low / (sqrt(2.0) * std_m)))
            table[0, i, j] = value
    spread = np.empty((cells, cells))
    for n in range(1, 1 + steps):
        offset = sqrt(3.0 * (2 * n - 1)) * drift_mps * step_s / cell_m
        for i in range(cells):
            for j in range(cells):
                sides = between(table[n - 1], i, j - offset) + between(table[n - 1], i, j + offset)
                spread[i, j] = (4.0 * table[n - 1, i, j] + sides) / 6.0
        for i in range(cells):
            for j in range(cells):
                least = np.inf
                for action in range(ACTIONS):
                    to = i + (2.0 * action / (ACTIONS - 1) - 1.0) * speed_mps * step_s / cell_m
                    to = min(max(to, 0.0), cells - 1.0)
                    value = abs(to * cell_m - half_m) * step_s / flight_s + between(spread, to, j)
                    least = min(least, value)
                table[n, i, j] = least
    return table


@kernel
def expected(table, time_s, w_m, miss_m, std_m, step_s, half_m, cell_m):
    """The mean of V over a miss that is normal with this mean and standard deviation, m."""
    at = min(max(time_s / step_s, 0.0), table.shape[0] - 1.0)
    n = min(int(floor(at)), table.shape[0] - 2)
    share, total = at - n, 0.0
    x = (w_m + half_m) / cell_m
    for node in range(len(NODES)):
        y = (miss_m + std_m * NODES[node] + half_m) / cell_m
        value = (1.0 - share) * between(table[n], x, y) + share * between(table[n + 1], x, y)
        total += WEIGHTS[node] * value
    return total
