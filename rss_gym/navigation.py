"""Navigation solutions of a block of rows; every loop runs over the lanes of the block."""

from rss_gym.jit import inner
from rss_gym.positioning.trilateration import closed_form, fix_std_m, gauss_newton
from rss_gym.state import DEAD_RECKONING, GNSS, NODES, RSS

GAUSS_NEWTON_STEPS = 3


@inner(forceinline=True)
def localisation(config, a):
    """How aircraft `a` knows its position."""
    return config.agent_localisation if a == 0 else config.intruder_localisation


@inner
def navigate(config, block, aircraft, mode):
    """One tick of the solution (m, m/s) by `mode`; an `rss` solution is dead-reckoned between its fixes."""
    s, sv, u, v, drift, t = (
        aircraft.solution_m, aircraft.solution_mps, aircraft.position_m, aircraft.velocity_mps, aircraft.drift_m,
        config.tick_s,
    )  # fmt: skip
    for axis in range(3):
        scale = config.gnss_m if axis < 2 else config.gnss_vertical_m
        for r in range(block.rows):
            sv[axis, r] = v[axis, r] + aircraft.gust_mps[axis, r] + aircraft.velocity_error_mps[axis, r]
            if mode == GNSS:
                s[axis, r] = u[axis, r] + scale * aircraft.gnss_error_m[axis, r]
            elif mode == DEAD_RECKONING:
                drift[axis, r] += aircraft.velocity_error_mps[axis, r] * t
                s[axis, r] = u[axis, r] + drift[axis, r]
            else:
                s[axis, r] += sv[axis, r] * t


@inner
def update_fixes(config, block, aircraft, links):
    """Accuracy (m) of everybody's solution, once a step; for `rss` also a fix by (1) from the strongest nodes."""
    for a in range(1 + config.intruders):
        one, mode = aircraft[a], localisation(config, a)
        if mode == RSS:
            choose_nodes(config, block, links, config.intruders + NODES * a)
            trilaterate(block, one)
        else:
            for r in range(block.rows):
                drifted_m = config.drift_mps * block.tick[r] * config.tick_s
                one.solution_std_m[r] = config.gnss_m if mode == GNSS else drifted_m


@inner
def choose_nodes(config, block, links, first):
    """The strongest signals come from the nearest nodes: leave the farthest out (Sec. IX-A)."""
    for r in range(block.rows):
        farthest = 0
        for j in range(1, NODES):
            if links[first + j].range_m[r] > links[first + farthest].range_m[r]:
                farthest = j
        n = 0
        for j in range(NODES):
            if j != farthest:
                node, link = config.nodes_m[j], links[first + j]
                block.node_x_m[n, r], block.node_y_m[n, r], block.node_z_m[n, r] = node[0], node[1], node[2]
                block.node_range_m[n, r], block.node_weight_pm2[n, r] = link.range_m[r], 1.0 / link.p_dd[r]
                n += 1


@inner(forceinline=True)
def chosen_nodes(block, r):
    """Positions, ranges and weights of the three nodes of lane r."""
    x, y, z = block.node_x_m, block.node_y_m, block.node_z_m
    d, w = block.node_range_m, block.node_weight_pm2
    nodes = (x[0, r], y[0, r], z[0, r]), (x[1, r], y[1, r], z[1, r]), (x[2, r], y[2, r], z[2, r])
    return nodes, (d[0, r], d[1, r], d[2, r]), (w[0, r], w[1, r], w[2, r])


@inner
def trilaterate(block, aircraft):
    """`trilateration.trilaterate`, one iteration of all lanes at a time: `solution_m` and `solution_std_m`."""
    s = aircraft.solution_m
    for r in range(block.rows):
        s[2, r] = aircraft.position_m[2, r] + aircraft.barometer_error_m[r] + aircraft.datum_error_m[r]
        nodes, ranges, _ = chosen_nodes(block, r)
        s[0, r], s[1, r] = closed_form(nodes, ranges, s[2, r])
    for _ in range(GAUSS_NEWTON_STEPS):
        for r in range(block.rows):
            nodes, ranges, weights = chosen_nodes(block, r)
            s[0, r], s[1, r] = gauss_newton(nodes, ranges, weights, s[0, r], s[1, r], s[2, r])
    for r in range(block.rows):
        nodes, ranges, weights = chosen_nodes(block, r)
        aircraft.solution_std_m[r] = fix_std_m(nodes, ranges, weights, s[0, r], s[1, r], s[2, r])
