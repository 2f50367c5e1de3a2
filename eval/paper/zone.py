"""Figure 4 and the numbers of Section VI: the safety zone."""

from __future__ import annotations

import numpy as np

from rss_gym.eval.paper.number import Number, exact
from rss_gym.eval.paper.panel import BLUE, ORANGE, RED, Panel
from rss_gym.eval.paper.study import Study
from rss_gym.pages.figure import INK, MUTED, figure
from rss_gym.params import Params
from rss_gym.safety import coherence_s, radius_m, trials, trials_max

ZONE = Params().zone
PROBABILITY, SPEED_MPS, REACTION_S = ZONE.range_error_probability, ZONE.speed_relative_max_mps, ZONE.reaction_s
BOUND = ZONE.collision_probability
ERRORS_M = (4.0, 16.0)
ZONES_M = {4.0: 120.0, 16.0: 240.0}  # the paper's, by (40)
COHERENCE_MS = {1.0: 25.39, 2.0: 12.69, 3.0: 8.46}  # speed of each aircraft, m/s
CARRIERS = (
    ("2.5", 2.5e9, tuple(COHERENCE_MS), ""),
    ("2.462", 2.462e9, (1.0,), "at the carrier that the paper's radios used; its times are those of 2.5 GHz"),
)


def zone(study: Study) -> Panel:
    """Figure 4, and the numbers of Section VI."""
    n_d = int(trials(PROBABILITY, BOUND))
    radii = {delta: float(radius_m(delta, PROBABILITY, SPEED_MPS, REACTION_S, n_d)) for delta in ERRORS_M}
    with figure("The safety zone round an aircraft", width_in=5.0, height_in=4.0) as drawing:
        axes, radius = drawing.axes, radii[4.0]
        other = np.array([95.0, 45.0])
        turn = np.linspace(0.0, 2.0 * np.pi, 200)
        axes.fill(radius * np.cos(turn), radius * np.sin(turn), color=BLUE, alpha=0.12, linewidth=0.0)
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=BLUE)
        axes.annotate("", (-radius, 0.0), (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": MUTED})
        axes.text(-0.5 * radius, 6.0, f"S = {radius:g} m", ha="center", color=MUTED)
        axes.plot(*np.transpose([[0.0, 0.0], other]), color=RED, linestyle="--", linewidth=1.0)
        axes.text(0.0, 60.0, f"d = {np.linalg.norm(other):.0f} m ≤ S: warning", color=RED, ha="center")
        axes.plot(0.0, 0.0, "o", color=BLUE)
        axes.plot(*other, "o", color=ORANGE)
        axes.annotate("$U_i$", (0.0, 0.0), (-5.0, -16.0), textcoords="offset points", color=INK)
        axes.annotate("$U_k$", other, (6.0, 4.0), textcoords="offset points", color=INK)
        axes.set(aspect="equal", xlabel="east, m", ylabel="north, m", xlim=(-150.0, 150.0), ylim=(-130.0, 130.0))
    looks = int(trials_max(COHERENCE_MS[1.0] / 1000.0))
    numbers = [
        Number(
            id="n_d",
            what="looks n_d (37) for P = 0.8 and a collision probability of 1e-5",
            paper=8.0,
            seen=exact(n_d),
            role="reproduced",
        ),
        *(
            Number(
                id=f"S-{delta:g}",
                what=f"radius S (40) for errors of {delta:g} m at 80 %",
                paper=ZONES_M[delta],
                seen=exact(radii[delta]),
                unit="m",
                role="reproduced",
            )
            for delta in ERRORS_M
        ),
        Number(
            id="N_d",
            what="most independent looks N_d (38)-(39) in a second at a coherence time of 25.39 ms",
            paper=40.0,
            seen=exact(looks),
            role="reproduced",
            tolerance=1.0,
            note="1 / 25.39 ms is 39.4: (38) takes the whole part, (39) says about 40",
        ),
        *(
            Number(
                id=f"coherence-{label}-{speed:g}",
                what=f"coherence time at {speed:g} m/s and {label} GHz",
                paper=COHERENCE_MS[speed],
                seen=exact(1000.0 * float(coherence_s(speed, carrier))),
                unit="ms",
                role="reproduced" if label == "2.5" else "beside",
                tolerance=0.005,
                note=note,
            )
            for label, carrier, speeds, note in CARRIERS
            for speed in speeds
        ),
    ]
    return Panel(
        "Figure 4: safety zone",
        drawing.html,
        "A warning is due when the distance to another aircraft is at most S (29).",
        f"Drawn to scale with S of (40). With P = 0.8 and 1e-5, (37) gives {n_d} looks and (40) {radii[4.0]:g} m and "
        f"{radii[16.0]:g} m, as printed.",
        tuple(numbers),
    )
