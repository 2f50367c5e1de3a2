"""Degenerate encounters, written by hand: the corners where a closed form divides by zero or a sign is undecided."""

from rss_gym.encounters.family import Family, Script

EXACT_HEAD_ON = Family(
    summary="opposite headings on one line, 3 m/s each",
    weight=0.0,
    script=Script(own_mps=3.0, start_m=(150.0, 0.0, 0.0), velocity_mps=(-3.0, 0.0), end_s=55.0),
)
TAIL_CHASE = Family(
    summary="the agent at 4 m/s overtakes an intruder at 2 m/s on its own line",
    weight=0.0,
    script=Script(own_mps=4.0, start_m=(140.0, 0.0, 0.0), velocity_mps=(2.0, 0.0), end_s=100.0),
)
EQUAL_VELOCITIES = Family(
    summary="side by side 30 m apart with equal velocities",
    weight=0.0,
    script=Script(own_mps=3.0, start_m=(0.0, 30.0, 0.0), velocity_mps=(3.0, 0.0), end_s=60.0),
)
HOVERING = Family(
    summary="an intruder that hovers on the agent's path",
    weight=0.0,
    script=Script(own_mps=3.0, start_m=(150.0, 0.0, 0.0), velocity_mps=(0.0, 0.0), end_s=80.0),
)
START_NEAR_ZONE = Family(
    summary="a crossing that begins on the edge of the safety zone, 120 m away",
    weight=0.0,
    script=Script(own_mps=3.0, start_m=(84.9, 84.9, 0.0), velocity_mps=(0.0, -3.0), end_s=60.0),
)
