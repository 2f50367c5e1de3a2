"""Where the factor of two lives: the white and the coloured filter over radios and speeds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rss_gym.eval.intervals import Interval
from rss_gym.eval.paper.flights import PERIOD_S
from rss_gym.eval.paper.number import Number
from rss_gym.eval.paper.panel import BLUE, GREEN, ORANGE, VIOLET, Panel
from rss_gym.eval.paper.study import Size, Study
from rss_gym.pages.figure import MUTED, figure
from rss_gym.params import Channel
from rss_gym.radio import GaussMarkov, allan_model

RATIOS = (1.0, 4.0, 16.0, 64.0)  # S / R
TIMES_S = (0.05, 0.15, 0.5, 1.5, 5.0, 15.0)
PACES = (0.5, 1.0, 2.0)  # of the twelve flights, at 2 to 5 m/s
FLAT = 0.1  # a slope of the Allan variance that counts as none
TUNING = 24  # repetitions of the eight flights on which each filter is tuned
QUICK_S = 1.5  # noise that ends within the turns of the flights
COLOURS = (VIOLET, GREEN, ORANGE, BLUE)


@dataclass(frozen=True)
class Point:
    """One radio at one pace: 80 % errors, m, in the median of the repetitions."""

    ratio: float
    tc_s: float
    pace: float
    coloured_m: float
    white_m: float  # variance R + S, a process noise of its own
    same_m: float  # variance R, the process noise of the coloured filter

    @property
    def factor(self) -> float:
        """What the paper compares: the same parameters but for the coloured noise."""
        return self.same_m / self.coloured_m

    @property
    def tuned(self) -> float:
        """The same with each filter tuned."""
        return self.white_m / self.coloured_m


@lru_cache(maxsize=4)
def points(size: Size, seed: int, channel: Channel) -> tuple[Point, ...]:
    """Every radio of the scan at every pace, with the total noise of `channel`, so that least squares errs alike."""
    total_db2 = channel.white_variance_db2 + channel.coloured_variance_db2
    few = size.replace(repetitions=max(size.scan, 2), tuning=min(size.tuning, TUNING))
    found = []
    for ratio in RATIOS:
        for tc_s in TIMES_S:
            radio = channel.replace(
                white_variance_db2=total_db2 / (1.0 + ratio),
                coloured_variance_db2=total_db2 * ratio / (1.0 + ratio),
                coloured_tc_s=tc_s,
            )
            for pace in PACES:
                study = Study(few, seed, radio, pace)
                p80_m = [study.p80_m("coloured"), study.p80_m("white"), study.p80_untuned_m()]
                found.append(Point(ratio, tc_s, pace, *(float(np.median(one)) for one in p80_m)))
    return tuple(found)


def slope(ratio: float, tc_s: float) -> float:
    """The exact slope of the Allan variance between one and two samples, for S / R and Tc."""
    noise = GaussMarkov(ratio / (1.0 + ratio), tc_s)
    first, second = allan_model(np.array([1.0, 2.0]), 1.0 / (1.0 + ratio), noise, PERIOD_S)
    return float(np.log2(second / first))


def scan(study: Study) -> Panel:
    """Figure 11 (a) over other radios and speeds."""
    everything = points(study.size, study.seed, study.channel)
    with figure(
        "Error of the white filter over that of the coloured one", columns=2, height_in=3.8, sharey=True
    ) as drawing:
        for axes, name in zip(drawing.axes, ("factor", "tuned"), strict=True):
            for ratio, colour in zip(RATIOS, COLOURS, strict=True):
                for pace, style in zip(PACES, (":", "-", "--"), strict=True):
                    own = [point for point in everything if (point.ratio, point.pace) == (ratio, pace)]
                    label = f"S / R = {ratio:g}" if pace == 1.0 else None
                    axes.plot(
                        [point.tc_s for point in own], [getattr(point, name) for point in own], style, color=colour,
                        marker="o", markersize=3.0, linewidth=1.6 if pace == 1.0 else 0.9, label=label,
                    )  # fmt: skip
            axes.axhline(2.0, color=MUTED, linewidth=0.8, linestyle=(0, (2, 3)))
            axes.axhline(1.0, color=MUTED, linewidth=0.8)
            axes.set(
                xscale="log", yscale="log", xlabel="correlation time Tc, s", xlim=(TIMES_S[0] / 1.3, TIMES_S[-1] * 1.3)
            )
            axes.set_yticks([1.0, 2.0, 4.0], ["1", "2", "4"])
            axes.minorticks_off()
        left, right = drawing.axes
        left.set_ylabel("error over that of the coloured filter")
        left.set_title("R alone, the coloured filter's process noise", loc="left")
        right.set_title("R + S, a process noise of its own", loc="left")
        left.legend(loc="upper right")
    tuned = np.array([point.tuned for point in everything])
    quick = np.array([point.tuned for point in everything if point.tc_s <= QUICK_S])
    factors = np.array([point.factor for point in everything])
    near_two = sorted({(p.ratio, p.tc_s) for p in everything if p.pace == 1.0 and p.factor >= 1.8})
    flat = [
        tc_s
        for tc_s in TIMES_S
        if slope(study.channel.coloured_variance_db2 / study.channel.white_variance_db2, tc_s) >= -FLAT
    ]
    runs = f"{len(everything)} combinations of S / R, Tc and speed, {study.size.scan} repetitions each"
    numbers = (
        Number(
            id="scan-factor",
            what="white filter (R alone, noise of the coloured one) over the coloured one: median, least, largest",
            paper=8.5 / 4.0,
            seen=_spread(factors),
            role="beside",
            note=f"1.8 or more at the paper's speeds for (S / R, Tc) = "
            f"{', '.join(f'({ratio:g}, {tc_s:g} s)' for ratio, tc_s in near_two) or 'none'}; {runs}",
        ),
        Number(
            id="scan-tuned",
            what="white filter (R + S, process noise of its own) over the coloured one: median, least, largest",
            paper=1.0,
            seen=_spread(tuned),
            role="beside",
            note=f"a filter that is tuned hardly gains by the model of the noise, wherever the radio lies; {runs}",
        ),
    )
    return Panel(
        "Figure 11 (a) over other radios: where the factor of two lies",
        drawing.html,
        "The error of the coloured model is about half that of the white one; the paper adds that this depends on the "
        "environment.",
        "All radios have the total noise of the preset, for which least squares errs as in the paper. Lines: "
        "the paper's "
        "speeds; dots: half, dashes: twice. With the same process noise and R alone (left) the white filter "
        "errs up to "
        f"{factors.max():.1f} times as much; each tuned with the whole variance (right) between {tuned.min():.2f} and "
        f"{tuned.max():.2f} times, up to Tc = {QUICK_S:g} s between {quick.min():.2f} and {quick.max():.2f}. The "
        "preset has the least Tc of the scan at which the Allan variance does not "
        "fall at "
        f"short τ, by more than τ^{FLAT:g}: {flat[0] if flat else TIMES_S[0]:g} s. White with R alone, coloured, with "
        "velocity and adaptive γ did not enter into its choice.",
        numbers,
    )


def _spread(values: np.ndarray) -> Interval:
    return Interval(float(np.median(values)), float(values.min()), float(values.max()), len(values))
