"""The paper's comparison on other radios: the preset `outdoor`, whose noise is slow, and a recorded 802.11 set."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rss_gym.eval.intervals import Interval
from rss_gym.eval.paper.number import MIDDLE, Number, over
from rss_gym.eval.paper.panel import BLUE, GREEN, ORANGE, RED, Panel
from rss_gym.eval.paper.recorded import FOLDER, recorded
from rss_gym.eval.paper.study import Study
from rss_gym.pages.figure import INK, figure

# Key -> what it is, the paper's figure, its colour.
METHODS = {
    "ls": ("least squares", 10.0, ORANGE),
    "white-same": ("white (R alone), process noise of the coloured filter", 8.5, RED),
    "white": ("white (R + S), process noise of its own", 8.5, GREEN),
    "coloured": ("coloured", 4.0, BLUE),
}


def contrast(study: Study) -> Panel:
    """Figure 11 (a) on other radios."""
    outdoor = Study(study.size, study.seed, "outdoor")
    radios = {"preset paper": _p80_m(study), "preset outdoor": _p80_m(outdoor)}
    seen = {name: {key: over(values) for key, values in found.items()} for name, found in radios.items()}
    logs = recorded(study.seed)
    if logs is not None:
        seen["recorded 802.11"] = {key: _of_records(values) for key, values in logs.p80_m.items()}
    with figure("Range errors at 80 % on several radios", height_in=3.6) as drawing:
        axes, width = drawing.axes, 0.8 / len(METHODS)
        places = np.arange(1.0 + len(seen))
        for n, (key, (label, paper, colour)) in enumerate(METHODS.items()):
            at = places + (n - 1.5) * width
            values = [paper if key != "white" else 0.0, *(found[key].value or 0.0 for found in seen.values())]
            axes.bar(at, values, 0.9 * width, color=colour, label=label)
            for x, found in zip(at[1:], seen.values(), strict=True):
                axes.plot([x, x], [found[key].low, found[key].high], color=INK, linewidth=1.0)
        axes.set_xticks(places, ["the paper", *seen])
        axes.set(ylabel="80 % of the errors within, m", ylim=(0.0, None))
        axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=2)
    numbers = [
        Number(
            id=f"{id_}-{key}",
            what=f"error on {name}, 80 %: {METHODS[key][0]}",
            paper=METHODS[key][1],
            seen=seen[name][key],
            unit="m",
            role="beside",
            note=note,
        )
        for id_, name, note in (
            ("outdoor", "preset outdoor", f"noise that stays for {outdoor.channel.coloured_tc_s:g} s"),
            (
                "recorded",
                "recorded 802.11",
                "two circuits fitted, two tested; 95 % of bootstrap samples of whole records",
            ),
        )
        if name in seen
        for key in METHODS
    ]
    numbers.append(
        Number(
            id="outdoor-velocity",
            what="error on preset outdoor, 80 %: coloured, with velocity",
            paper=1.7,
            seen=over(outdoor.p80_m("coloured-velocity")),
            unit="m",
            role="beside",
            note=f"{study.size.repetitions} repetitions",
        )
    )
    slow = seen["preset outdoor"]
    said = (
        f"On the preset outdoor, whose noise is as strong against least squares but stays for "
        f"{outdoor.channel.coloured_tc_s:g} s, the coloured filter comes to {slow['coloured'].value:.1f} m: a "
        "change of range "
        "looks like the noise to it. "
    )
    if logs is not None:
        real = seen["recorded 802.11"]
        said += (
            f"On {logs.samples:,} recorded samples of 802.11 it is {real['ls'].value:.1f}, "
            f"{real['white-same'].value:.1f} and "
            f"{real['coloured'].value:.1f} m in the paper's order: its pattern. The tuned white filter comes to "
            f"{real['white'].value:.1f} m there."
        )
    else:
        said += f"A recorded set of 802.11 is compared too where the folder {FOLDER} lies in that of RSS_GYM_DATA."
    return Panel(
        "Figure 11 (a) on other radios: slow noise, and recorded logs",
        drawing.html,
        "80 % within about 10 m with least squares, 8.5 m with the white noise model, 4 m with the coloured one.",
        said,
        tuple(numbers),
    )


def _p80_m(study: Study) -> dict[str, NDArray[np.float64]]:
    own = {key: study.p80_m(key) for key in ("ls", "white", "coloured")}
    return own | {"white-same": study.p80_untuned_m()}


def _of_records(values: NDArray[np.float64]) -> Interval:
    """All records, and the middle 95 % of their bootstrap samples."""
    low, high = np.quantile(values[1:], MIDDLE)
    return Interval(
        float(values[0]), min(float(low), float(values[0])), max(float(high), float(values[0])), len(values) - 1
    )
