"""Position from ranges to reference nodes, (1), with the three strongest nodes of Sec. IX-A."""

from math import sqrt

from rss_gym.jit import kernel


@kernel
def trilaterate(nodes_m, ranges_m, variances_m2, altitude_m, steps):
    """Horizontal position from three ranges and a known altitude: weighted least squares of (1) by Gauss-Newton.

    The start is the closed form: differences of the squared ranges, which are linear in x and y.

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
    x0, y0 = nodes_m[0][0], nodes_m[0][1]
    h0 = ranges_m[0] * ranges_m[0] - (altitude_m - nodes_m[0][2]) * (altitude_m - nodes_m[0][2])
    ax, ay = nodes_m[1][0] - x0, nodes_m[1][1] - y0
    bx, by = nodes_m[2][0] - x0, nodes_m[2][1] - y0
    ha = ranges_m[1] * ranges_m[1] - (altitude_m - nodes_m[1][2]) * (altitude_m - nodes_m[1][2])
    hb = ranges_m[2] * ranges_m[2] - (altitude_m - nodes_m[2][2]) * (altitude_m - nodes_m[2][2])
    ca = 0.5 * (ax * ax + ay * ay + h0 - ha)
    cb = 0.5 * (bx * bx + by * by + h0 - hb)
    det = ax * by - ay * bx
    x, y = x0 + (ca * by - cb * ay) / det, y0 + (ax * cb - bx * ca) / det
    std = 0.0
    for step in range(steps + 1):
        nxx = nxy = nyy = gx = gy = 0.0
        for j in range(3):
            dx, dy, dz = x - nodes_m[j][0], y - nodes_m[j][1], altitude_m - nodes_m[j][2]
            d = sqrt(dx * dx + dy * dy + dz * dz) + 1e-9
            weight, hx, hy = 1.0 / variances_m2[j], dx / d, dy / d
            nxx += weight * hx * hx
            nxy += weight * hx * hy
            nyy += weight * hy * hy
            gx += weight * hx * (ranges_m[j] - d)
            gy += weight * hy * (ranges_m[j] - d)
        # A little damping keeps the step finite when the three bearings are nearly one line.
        damping = 1e-3 * (nxx + nyy)
        nxx, nyy = nxx + damping, nyy + damping
        det = nxx * nyy - nxy * nxy
        std = sqrt(0.5 * (nxx + nyy) / det)
        if step < steps:
            x += (nyy * gx - nxy * gy) / det
            y += (nxx * gy - nxy * gx) / det
    return x, y, std
