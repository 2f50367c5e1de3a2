"""Position from ranges to reference nodes, (1), with the three strongest nodes of Sec. IX-A."""

from math import sqrt

from rss_gym.jit import kernel


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


@kernel(inline="always")
def trilaterate(nodes_m, ranges_m, variances_m2, altitude_m, steps):
    """Horizontal position from three ranges and a known altitude: weighted least squares of (1) by Gauss-Newton.

    Parameters
    ----------
    nodes_m : three (3,) arrays
        Nodes' positions; not on one vertical plane.
    ranges_m, variances_m2 : three floats
        Estimated ranges and their variances.
    altitude_m : float
        The aircraft's altitude, from its barometer.
    steps : int
        Gauss-Newton steps after the closed form.

    Returns
    -------
    tuple of float
        x, y and the standard deviation per axis of the solution, m.
    """
    weights = 1.0 / variances_m2[0], 1.0 / variances_m2[1], 1.0 / variances_m2[2]
    x, y = closed_form(nodes_m, ranges_m, altitude_m)
    for _ in range(steps):
        x, y = gauss_newton(nodes_m, ranges_m, weights, x, y, altitude_m)
    return x, y, fix_std_m(nodes_m, ranges_m, weights, x, y, altitude_m)
