"""The table that the commands print."""

from __future__ import annotations

from collections.abc import Mapping

from rss_gym.eval.evaluate import Result
from rss_gym.eval.metrics import Estimate

COLUMNS = {
    "collision_rate": ("collision rate", 1.0, ".2e"),
    "snmac_rate": ("sNMAC rate", 1.0, ".2e"),
    "zone_violation_rate": ("zone rate", 1.0, ".3f"),
    "path_deviation_mean_m": ("deviation m", 1.0, ".2f"),
}


def cell(estimate: Estimate, scale: float, form: str) -> str:
    """Value and interval."""
    if estimate.value is None:
        return "-"
    text = format(estimate.value * scale, form)
    if estimate.low is None or estimate.high is None:
        return text
    return f"{text} [{format(estimate.low * scale, form)}, {format(estimate.high * scale, form)}]"


def table(result: Result, columns: Mapping[str, tuple[str, float, str]] = COLUMNS) -> str:
    """One line a policy: the metrics of `columns` (title, factor, format) with their 95 % intervals."""
    rows = [["policy", "track", *(title for title, _, _ in columns.values())]]
    for scored in result.policies:
        cells = [cell(scored.metrics[name], scale, form) for name, (_, scale, form) in columns.items()]
        rows.append([scored.entry.name, scored.entry.world.interface.track, *cells])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    lines.insert(1, "  ".join("-" * width for width in widths))
    lines.append(
        f"{result.episodes} encounters of suite {result.suite.name}, split {result.suite.split}, seed {result.seed}; "
        "95 % intervals; rates are per encounter of this distribution, not per flight hour"
    )
    return "\n".join(lines)
