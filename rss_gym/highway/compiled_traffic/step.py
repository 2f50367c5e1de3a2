"""The ticks of a decision."""

from math import cos, sin

from rss_gym.highway.compiled_traffic.drivers import act_controlled, act_idm
from rss_gym.highway.compiled_traffic.geometry import coordinates, heading_at
from rss_gym.highway.compiled_traffic.motion import collide, move
from rss_gym.highway.compiled_traffic.records import CONTROLLED, IDM, OBSTACLE
from rss_gym.jit import kernel


@kernel
def drive(vehicles, agent, lanes, ticks, tick_s, states, roads):
    """Drive for some ticks.

    Parameters
    ----------
    vehicles : (n,) VEHICLE
        In the order of the road, the objects last.
    agent : int
        Its row.
    lanes : (m,) LANE
    ticks : int
    tick_s : float
    states : (ticks, n, 4) array
        Written: x (m), y (m), heading (rad) and speed (m/s) after each tick.
    roads : (ticks, 3) array
        Written: direction of the agent's lane (cosine, sine), and how far (m) the agent is to the right of its centre.
    """
    for t in range(ticks):
        for i in range(len(vehicles)):
            if vehicles[i].kind == CONTROLLED:
                act_controlled(vehicles[i], lanes)
            elif vehicles[i].kind == IDM:
                act_idm(i, vehicles, lanes)
        for i in range(len(vehicles)):
            if vehicles[i].kind != OBSTACLE:
                move(vehicles[i], lanes, tick_s)
        for i in range(len(vehicles)):
            if vehicles[i].kind != OBSTACLE:
                for j in range(i + 1, len(vehicles)):
                    collide(vehicles[i], vehicles[j], tick_s)
        for i in range(len(vehicles)):
            v = vehicles[i]
            states[t, i, 0], states[t, i, 1] = v.position_m[0], v.position_m[1]
            states[t, i, 2], states[t, i, 3] = v.heading, v.speed_mps
        v = vehicles[agent]
        along_m, roads[t, 2] = coordinates(lanes[v.lane], v.position_m)
        heading = heading_at(lanes[v.lane], along_m)
        roads[t, 0], roads[t, 1] = cos(heading), sin(heading)
