"""Position from ranges to reference nodes, (1), with the three strongest nodes of Sec. IX-A."""

from math import sqrt

import numpy as np

from rss_gym.jit import kernel

DESCENT_STEPS = 100


@kernel(inline="always")
def closed_form(nodes_m, ranges_m, altitude_m):
    """Horizontal position from three ranges and a known altitude: differences of (1), which are linear in x and y."""
    x0, y0 = nodes_m[0][0], nodes_m[0][1]
    h0 = ranges_m[0] * ranges_m[0] - (altitude_m - nodes_m[0][2]) * (altitude_m - nodes_m[0][2])
    ax, ay = nodes_m[1][0] - x0, nodes_m[1][1] - y0
    bx, by = nodes_m[2][0] - x0, nodes_m[2][1] - y0
    ha = ranges_m[1] * ranges_m[1] - (altitude_m - nodes_m[1][2]) * (altitude_m - nodes_m[1][2])
    hb = ranges_m[2] * ranges_m[2] - (altitude_m - nodes_m[2][2]) * (altitude_m - nodes_m[2][2])
    ca = 0.5 * (ax * ax + ay * ay + h0 - ha)
    cb = 0.5 * (bx * bx + by * by + h0 - hb)
    det = ax * by - ay * bx
    return x0 + (ca * by - cb * ay) / det, y0 + (ax * cb - bx * ca) / det


@kernel(forceinline=True)
def sight(node_m, range_m, weight_pm2, x_m, y_m, altitude_m):
    """What one range adds to the normal equations of (1) linearised at (x, y): nxx, nxy, nyy, gx, gy."""
    dx, dy, dz = x_m - node_m[0], y_m - node_m[1], altitude_m - node_m[2]
    d = sqrt(dx * dx + dy * dy + dz * dz) + 1e-9
    hx, hy, residual = dx / d, dy / d, range_m - d
    return (
        weight_pm2 * hx * hx,
        weight_pm2 * hx * hy,
        weight_pm2 * hy * hy,
        weight_pm2 * hx * residual,
        weight_pm2 * hy * residual,
    )


@kernel(forceinline=True)
def normal_equations(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m):
    """The normal equations of three ranges; a little damping keeps the step finite when the bearings are one line."""
    axx, axy, ayy, ax, ay = sight(nodes_m[0], ranges_m[0], weights_pm2[0], x_m, y_m, altitude_m)
    bxx, bxy, byy, bx, by = sight(nodes_m[1], ranges_m[1], weights_pm2[1], x_m, y_m, altitude_m)
    cxx, cxy, cyy, cx, cy = sight(nodes_m[2], ranges_m[2], weights_pm2[2], x_m, y_m, altitude_m)
    nxx, nxy, nyy = axx + bxx + cxx, axy + bxy + cxy, ayy + byy + cyy
    damping = 1e-3 * (nxx + nyy)
    return nxx + damping, nxy, nyy + damping, ax + bx + cx, ay + by + cy


@kernel(inline="always")
def gauss_newton(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m):
    """One Gauss-Newton step of the weighted least squares of (1)."""
    nxx, nxy, nyy, gx, gy = normal_equations(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m)
    det = nxx * nyy - nxy * nxy
    return x_m + (nyy * gx - nxy * gy) / det, y_m + (nxx * gy - nxy * gx) / det


@kernel(inline="always")
def fix_std_m(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m):
    """Standard deviation per axis of the solution, m."""
    nxx, nxy, nyy, _, _ = normal_equations(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m)
    return sqrt(0.5 * (nxx + nyy) / (nxx * nyy - nxy * nxy))


@kernel
def misfit(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m):
    """Weighted sum of the squared residuals of (1)."""
    total = 0.0
    for j in range(3):
        dx, dy, dz = x_m - nodes_m[j][0], y_m - nodes_m[j][1], altitude_m - nodes_m[j][2]
        residual = ranges_m[j] - sqrt(dx * dx + dy * dy + dz * dz)
        total += weights_pm2[j] * residual * residual
    return total


@kernel
def descend(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m):
    """The minimum of `misfit` below (x, y), and its value: Newton's steps, damped where the misfit does not fall.

    The two curvatures enter by their size, so that a step goes downhill where the misfit curves downwards.
    """
    best = misfit(nodes_m, ranges_m, weights_pm2, x_m, y_m, altitude_m)
    damping = 1e-9
    for _ in range(DESCENT_STEPS):
        hxx, hxy, hyy, gx, gy = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(3):
            dx, dy, dz = x_m - nodes_m[j][0], y_m - nodes_m[j][1], altitude_m - nodes_m[j][2]
            d = sqrt(dx * dx + dy * dy + dz * dz) + 1e-9
            ux, uy, w = dx / d, dy / d, weights_pm2[j]
            bend = w * (ranges_m[j] / d - 1.0)
            gx += w * (ranges_m[j] - d) * ux
            gy += w * (ranges_m[j] - d) * uy
            hxx += w * ux * ux - bend * (1.0 - ux * ux)
            hxy += w * ux * uy + bend * ux * uy
            hyy += w * uy * uy - bend * (1.0 - uy * uy)
        middle, half = 0.5 * (hxx + hyy), 0.5 * (hxx - hyy)
        radius = sqrt(half * half + hxy * hxy)
        # Axes of curvature: (cx, cy) for the larger, (-cy, cx) for the smaller.
        cx, cy = half + radius, hxy
        if half < 0.0:
            cx, cy = hxy, radius - half
        length = sqrt(cx * cx + cy * cy)
        if length == 0.0:
            cx, cy, length = 1.0, 0.0, 1.0
        cx, cy = cx / length, cy / length
        floor = damping * (weights_pm2[0] + weights_pm2[1] + weights_pm2[2])
        along = (gx * cx + gy * cy) / (abs(middle + radius) + floor)
        across = (gy * cx - gx * cy) / (abs(middle - radius) + floor)
        x, y = x_m + along * cx - across * cy, y_m + along * cy + across * cx
        trial = misfit(nodes_m, ranges_m, weights_pm2, x, y, altitude_m)
        moved = abs(x - x_m) + abs(y - y_m)
        if trial < best:
            x_m, y_m, best, damping = x, y, trial, max(0.1 * damping, 1e-9)
        else:
            damping *= 10.0
        if moved <= 1e-9 * (1.0 + abs(x_m) + abs(y_m)):
            break
    return x_m, y_m, best


@kernel
def trilaterate(nodes_m, ranges_m, variances_m2, altitude_m, steps):
    """Horizontal position from three ranges and a known altitude: the least of the weighted squares of (1).

    Ranges that do not fit together leave several minima. The descent begins from the world's solution and from the
    points where two of the circles meet, or are nearest; the lowest minimum is returned.

    Parameters
    ----------
    nodes_m : three (3,) arrays
        Nodes' positions; not on one vertical plane.
    ranges_m, variances_m2 : three floats
        Estimated ranges and their variances.
    altitude_m : float
        The aircraft's altitude, from its barometer.
    steps : int
        Gauss-Newton steps from the closed form to the world's solution, 3 in the world.

    Returns
    -------
    tuple of float
        x, y and the standard deviation per axis of the solution, m.
    """
    weights = 1.0 / variances_m2[0], 1.0 / variances_m2[1], 1.0 / variances_m2[2]
    x, y = closed_form(nodes_m, ranges_m, altitude_m)
    for _ in range(steps):
        x, y = gauss_newton(nodes_m, ranges_m, weights, x, y, altitude_m)
    best_x, best_y, best = x, y, np.inf
    if np.isfinite(x) and np.isfinite(y):
        best_x, best_y, best = descend(nodes_m, ranges_m, weights, x, y, altitude_m)
    for i in range(2):
        for j in range(i + 1, 3):
            ax, ay, bx, by = nodes_m[i][0], nodes_m[i][1], nodes_m[j][0], nodes_m[j][1]
            ra, rb = level_m(nodes_m[i], ranges_m[i], altitude_m), level_m(nodes_m[j], ranges_m[j], altitude_m)
            gap = sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
            if gap == 0.0:
                continue
            ex, ey = (bx - ax) / gap, (by - ay) / gap
            along = 0.5 * (gap + (ra * ra - rb * rb) / gap)
            along = min(max(along, -ra), ra)
            off = sqrt(max(ra * ra - along * along, (0.1 * gap) * (0.1 * gap)))
            for side in (-1.0, 1.0):
                x, y, value = descend(
                    nodes_m, ranges_m, weights, ax + along * ex - side * off * ey, ay + along * ey + side * off * ex,
                    altitude_m,
                )  # fmt: skip
                if value < best:
                    best_x, best_y, best = x, y, value
    return best_x, best_y, fix_std_m(nodes_m, ranges_m, weights, best_x, best_y, altitude_m)


@kernel
def level_m(node_m, range_m, altitude_m):
    """Radius of the circle at the aircraft's altitude on which one range places it; 0 where it is too short."""
    dz = altitude_m - node_m[2]
    return sqrt(max(range_m * range_m - dz * dz, 0.0))
