"""A table of values for one intruder, and its value on the belief of a track, in the spirit of QMDP.

Straight flight of both leads to a miss m, signed, along a unit vector n across the relative velocity, in a time t. The
own aircraft can displace its way point by w along n, so that the separation at the closest approach is |m - w|. For a
standard deviation s of the miss the table holds the least expected cost V(t, w, m) of its mean m, by value iteration
backwards from t = 0,

    V(0, w, m) = E price(|m + s e - w|) + w^2 / (2 u T)
    V(t, w, m) = min over u' in [-u, u] of |w'| dt / T + E V(t - dt, w', m + sqrt(t^2 - (t - dt)^2) a e),
        w' = w + u' dt

with T the length of a flight, u the speed across the path, a the standard deviation of the other's velocity, whose
part of the miss is known better as t gets shorter, and e a standard normal number.

Littman, Cassandra and Kaelbling (1995) take the mean of V over the belief as if the state were known from the next step
on. Where a position stays uncertain to the end, as here, that waits too long; so the part s is held.
"""

from math import erf, floor, log2, sqrt

import numpy as np

from rss_gym.jit import kernel

ACTIONS = 9  # speeds across the path in [-u, u]
SPREADS = 5  # standard deviations of the table: 1, 2, 4, 8, 16 m


@kernel(inline="always")
def between(table, x, y):
    """Bilinear interpolation of `table` at the indices x, y, held at its edges."""
    x, y = min(max(x, 0.0), table.shape[0] - 1.0), min(max(y, 0.0), table.shape[1] - 1.0)
    i, j = min(floor(x), table.shape[0] - 2), min(floor(y), table.shape[1] - 2)
    p, q = x - i, y - j
    low = (1.0 - q) * table[i, j] + q * table[i, j + 1]
    high = (1.0 - q) * table[i + 1, j] + q * table[i + 1, j + 1]
    return (1.0 - p) * low + p * high


@kernel
def solve(prices_m, limits_m, speed_mps, drift_mps, flight_s, step_s, steps, half_m, cell_m):
    """The table V (`SPREADS`, 1 + steps, cells, cells), m: by s, t in steps of `step_s`, w and m in [-half_m, half_m].

    Parameters
    ----------
    prices_m, limits_m : (2,) array
        What an sNMAC and a collision cost, and the separations below which they happen.
    speed_mps, drift_mps, flight_s : float
        u, a and T.
    step_s, steps, half_m, cell_m
        The grid.
    """
    cells = 1 + 2 * round(half_m / cell_m)
    table = np.empty((SPREADS, 1 + steps, cells, cells))
    for k in range(SPREADS):
        _iterate(table[k], prices_m, limits_m, 2.0**k, speed_mps, drift_mps, flight_s, step_s, half_m, cell_m)
    return table


@kernel
def _iterate(table, prices_m, limits_m, std_m, speed_mps, drift_mps, flight_s, step_s, half_m, cell_m):
    steps, cells = table.shape[0] - 1, table.shape[1]
    for i in range(cells):
        w = i * cell_m - half_m
        for j in range(cells):
            miss, value = j * cell_m - half_m - w, w * w / (2.0 * speed_mps * flight_s)
            for event in range(2):
                low, high = (-limits_m[event] - miss) / std_m, (limits_m[event] - miss) / std_m
                value += 0.5 * prices_m[event] * (erf(high / sqrt(2.0)) - erf(low / sqrt(2.0)))
            table[0, i, j] = value
    mean = np.empty((cells, cells))
    for n in range(1, 1 + steps):
        # Three points of Gauss and Hermite: weights 1/6, 2/3, 1/6.
        offset = sqrt(3.0 * (2 * n - 1)) * drift_mps * step_s / cell_m
        for i in range(cells):
            for j in range(cells):
                sides = between(table[n - 1], i, j - offset) + between(table[n - 1], i, j + offset)
                mean[i, j] = (4.0 * table[n - 1, i, j] + sides) / 6.0
        for i in range(cells):
            for j in range(cells):
                least = np.inf
                for action in range(ACTIONS):
                    to = i + (2.0 * action / (ACTIONS - 1) - 1.0) * speed_mps * step_s / cell_m
                    to = min(max(to, 0.0), cells - 1.0)
                    least = min(least, abs(to * cell_m - half_m) * step_s / flight_s + between(mean, to, j))
                table[n, i, j] = least


@kernel
def value(table, std_m, time_s, w_m, miss_m, step_s, half_m, cell_m):
    """V by interpolation, in s by its logarithm; held at the edges of the table."""
    level = min(max(log2(max(std_m, 1e-3)), 0.0), SPREADS - 1.0)
    k = min(floor(level), SPREADS - 2)
    at = min(max(time_s / step_s, 0.0), table.shape[1] - 1.0)
    n = min(floor(at), table.shape[1] - 2)
    x, y, total = (w_m + half_m) / cell_m, (miss_m + half_m) / cell_m, 0.0
    for up in range(2):
        share = level - k if up else 1.0 - level + k
        slab = table[k + up]
        total += share * ((1.0 - at + n) * between(slab[n], x, y) + (at - n) * between(slab[n + 1], x, y))
    return total
