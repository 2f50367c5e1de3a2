"""Figures 6, 13 and 14: the orthogonal rule (43)-(45), as printed and as flown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rss_gym.avoidance.literal import WayPoints, flown, literal
from rss_gym.eval.intervals import mean_t
from rss_gym.eval.paper.number import Number, exact
from rss_gym.eval.paper.panel import BLUE, GREEN, ORANGE, RED, Panel
from rss_gym.eval.paper.study import Study
from rss_gym.pages.figure import INK, MUTED, figure
from rss_gym.params import Params
from rss_gym.safety import STD_TO_80_PERCENT

Floats = NDArray[np.float64]

RADIUS_M = Params().zone.radius_m
STEPS = 120
SPEED_MAX_M = 5.0  # way in a frame of 1 s
TURN = 0.25  # standard deviation of the change of course in a frame, rad
ESTIMATE_STD_M = Params().zone.range_error_m / STD_TO_80_PERCENT
APART_M = (40.0, 160.0)  # between the starts of a pair
DIVERT = 0.5  # of S: what may still pass for "not significantly"
SHOWN = 0


@dataclass(frozen=True)
class Pair:
    """Two random trajectories with estimation noise, (n + 1, 2) each, and what the rule makes of the second."""

    one_m: Floats
    two_m: Floats
    velocity_mps: Floats  # (n, 2): v_i(n), which U_i knows and tells

    def by_rule(self) -> tuple[WayPoints, WayPoints]:
        """`literal` and `flown` at every step."""
        return (
            literal(self.one_m[:-1], self.one_m[1:], self.velocity_mps, self.two_m[:-1], self.two_m[1:], RADIUS_M),
            flown(self.one_m[1:], self.velocity_mps, self.two_m[1:], RADIUS_M),
        )


def drawing_of_rule(study: Study) -> Panel:
    """Figure 6."""
    one, ahead = np.zeros(2), np.array([0.0, 25.0])
    two, planned = np.array([70.0, 40.0]), np.array([55.0, 52.0])
    velocity = (ahead - one)[None]
    printed = literal(one[None], ahead[None], velocity, two[None], planned[None], RADIUS_M).next_j_m[0]
    params = flown(ahead[None], velocity, planned[None], RADIUS_M).next_j_m[0]
    with figure("The orthogonal rule", width_in=6.0, height_in=4.8) as drawing:
        axes = drawing.axes
        turn = np.linspace(0.0, 2.0 * np.pi, 300)
        for centre, style, label in (
            (one, "-", "zone round $u_i(n)$, as printed"),
            (ahead, "--", "zone round $u_i(n+1)$"),
        ):
            axes.plot(
                centre[0] + RADIUS_M * np.cos(turn),
                centre[1] + RADIUS_M * np.sin(turn),
                style,
                color=BLUE,
                linewidth=1.0,
                label=label,
            )
        for start, end, colour, style in (
            (one, ahead, BLUE, "-"),
            (two, planned, MUTED, "--"),
            (two, printed, ORANGE, "-"),
            (planned, params, GREEN, "-"),
        ):
            axes.annotate(
                "", end, start, arrowprops={"arrowstyle": "->", "color": colour, "linestyle": style, "lw": 1.4}
            )
        marks = (
            (one, "$u_i(n)$", BLUE, (-36.0, -4.0)),
            (ahead, "$u_i(n+1)$", BLUE, (-50.0, -2.0)),
            (two, "$u_j(n)$", ORANGE, (2.0, -14.0)),
            (planned, "predefined $u_j(n+1)$", MUTED, (-70.0, 8.0)),
            (printed, "$u_j(n+1)$ by (45)", ORANGE, (12.0, -10.0)),
            (params, "as flown", GREEN, (8.0, 2.0)),
        )
        for point, label, colour, offset in marks:
            axes.plot(*point, "o", color=colour, markersize=4.0)
            axes.annotate(label, point, offset, textcoords="offset points", color=INK, fontsize=8.0)
        axes.set(aspect="equal", xlabel="east, m", ylabel="north, m", xlim=(-130.0, 200.0), ylim=(-130.0, 150.0))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)
    return Panel(
        "Figure 6: orthogonal rule",
        drawing.html,
        "U_j goes to the edge of U_i's safety zone, at right angles to U_i's velocity.",
        "Computed by the library: the printed rule (45) moves U_j at right angles to the edge of the zone round "
        f"u_i(n), {np.linalg.norm(printed - ahead):.0f} m from u_i(n+1) here; with the zone round u_i(n+1) it is S = "
        f"{RADIUS_M:g} m.",
    )


def trajectories(study: Study) -> Panel:
    """Figure 13."""
    pair = _pair(study, SHOWN)
    printed, _ = pair.by_rule()
    with figure("Trajectories of two aircraft", width_in=6.0, height_in=4.6) as drawing:
        axes = drawing.axes
        axes.plot(*pair.one_m.T, color=BLUE, linewidth=1.0, label="UAV1")
        axes.plot(*pair.two_m.T, color=MUTED, linewidth=1.0, linestyle="--", label="UAV2 as predefined")
        axes.plot(*printed.next_j_m.T, color=ORANGE, linewidth=1.0, label="UAV2 by the rule")
        for start, colour in ((pair.one_m[0], BLUE), (pair.two_m[0], MUTED)):
            axes.plot(*start, "o", color=colour, markersize=5.0)
        axes.set(xlabel="east, m", ylabel="north, m")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.08)
        axes.legend(loc="best")
    moved, least = [], []
    for number in range(study.size.pairs):
        pair = _pair(study, number)
        printed, _ = pair.by_rule()
        apart = np.linalg.norm(pair.two_m[1:] - pair.one_m[1:], axis=1)
        if printed.changed.any():
            moved.append(np.linalg.norm(printed.next_j_m - pair.two_m[1:], axis=1)[printed.changed].mean() / RADIUS_M)
            least.append((RADIUS_M - apart)[printed.changed].mean() / RADIUS_M)
    mean, times = mean_t(np.array(moved)), float(np.sum(moved) / np.sum(least))
    divert = Number(
        id="fig13-divert",
        what="mean displacement of the way points that the rule changes, over S",
        paper=DIVERT,
        seen=mean,
        role="claim",
        relation="at most",
        note=f'the paper gives no figure; "not significantly" is read as half of S. This is {times:.2f} times '
        f"the least that leaves the zone; mean of {len(moved):,} random pairs",
    )
    return Panel(
        "Figure 13: trajectories",
        drawing.html,
        "The modified trajectory of UAV2 respects the safety zone and does not significantly divert from the "
        "predefined one.",
        f"One of {study.size.pairs:,} random pairs. The rule moves the way points it changes by {mean.value:.2f} S in "
        "the mean, and from step to step they may swap sides: a target for a controller, not a path to fly.",
        (divert,),
    )


def distances(study: Study) -> Panel:
    """Figure 14."""
    short = {"printed": np.zeros(study.size.pairs), "flown": np.zeros(study.size.pairs)}
    excess, share, changed_steps = -RADIUS_M, 0, 0
    for number in range(study.size.pairs):
        pair = _pair(study, number)
        step = np.linalg.norm(np.diff(pair.one_m, axis=0), axis=1)
        for name, found in zip(short, pair.by_rule(), strict=True):
            missing = RADIUS_M - np.linalg.norm(found.next_j_m - pair.one_m[1:], axis=1)
            short[name][number] = max(0.0, missing[found.due].max(initial=0.0))
            if name == "printed" and found.changed.any():
                excess = max(excess, float((missing - step)[found.changed].max()))
                share += int(np.sum(missing[found.changed] > 1e-9))
                changed_steps += int(found.changed.sum())
    pair = _pair(study, SHOWN)
    printed, params = pair.by_rule()
    with figure("Distance between the two aircraft") as drawing:
        axes, time = drawing.axes, np.arange(1, STEPS + 1)
        axes.plot(time, np.linalg.norm(pair.two_m[1:] - pair.one_m[1:], axis=1), color=MUTED, label="before")
        axes.plot(
            time,
            np.linalg.norm(printed.next_j_m - pair.one_m[1:], axis=1),
            color=ORANGE,
            label="after, rule as printed",
        )
        axes.plot(
            time,
            np.linalg.norm(params.next_j_m - pair.one_m[1:], axis=1),
            color=GREEN,
            linestyle="--",
            label="after, zone round $u_i(n+1)$",
        )
        axes.axhline(RADIUS_M, color=RED, linewidth=0.8, linestyle=":", label=f"S = {RADIUS_M:g} m")
        axes.set(xlabel="time, s", ylabel="distance, m", xlim=(0.0, STEPS), ylim=(0.0, None))
        axes.legend(loc="lower right", ncols=2)
    runs = f"{study.size.pairs:,} random pairs of {STEPS} steps"
    numbers = (
        Number(
            id="fig14-printed",
            what="largest shortfall of the new distance below S, rule as printed",
            paper=0.0,
            seen=exact(short["printed"].max(), study.size.pairs),
            unit="m",
            role="claim",
            relation="at most",
            note="(45) is centred on u_i(n) while the distance counts at n+1: "
            f"{100.0 * share / max(changed_steps, 1):.0f} % of the changed way points fall short; {runs}",
        ),
        Number(
            id="fig14-step",
            what="shortfall beyond the way of U_i in the step, rule as printed",
            paper=0.0,
            seen=exact(excess, study.size.pairs),
            unit="m",
            role="by construction",
            relation="at most",
            tolerance=1e-9,
            note="the way from u_i(n) to u_i(n+1), estimation noise included, bounds the shortfall",
        ),
        Number(
            id="fig14-flown",
            what="largest shortfall of the new distance below S, zone round u_i(n+1)",
            paper=0.0,
            seen=exact(short["flown"].max(), study.size.pairs),
            unit="m",
            role="claim",
            relation="at most",
            tolerance=1e-9,
            note=f"the form that the world flies; {runs}",
        ),
    )
    return Panel(
        "Figure 14: distances",
        drawing.html,
        "After modification the distance is at least the radius of the safety zone.",
        f"As printed, the rule falls short of S by up to {short['printed'].max():.1f} m; centred on the zone of n+1 "
        "it holds to rounding.",
        numbers,
    )


def _pair(study: Study, number: int) -> Pair:
    """Two irregular trajectories: courses drift at random, speeds are up to 5 m/s, positions are estimates."""
    random = np.random.default_rng([study.seed, number, 13])
    course = random.uniform(0.0, 2.0 * np.pi, (2, 1)) + np.cumsum(TURN * random.standard_normal((2, STEPS)), axis=1)
    way = random.uniform(0.0, SPEED_MAX_M, (2, STEPS))
    steps = np.stack([way * np.cos(course), way * np.sin(course)], axis=-1)
    start = np.zeros((2, 1, 2))
    angle = random.uniform(0.0, 2.0 * np.pi)
    start[1, 0] = random.uniform(*APART_M) * np.array([np.cos(angle), np.sin(angle)])
    true = np.concatenate([start, start + np.cumsum(steps, axis=1)], axis=1)
    one, two = true + ESTIMATE_STD_M / np.sqrt(2.0) * random.standard_normal(true.shape)
    return Pair(one, two, steps[0])
