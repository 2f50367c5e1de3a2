"""How a result shows itself: one line, a table for notebooks, and a data frame."""

from __future__ import annotations

from html import escape
from typing import Any

from rss_gym.params import ParamsError

NAMES_MAX = 8  # policies that the line names
COLUMNS = {  # metric -> title in a notebook's table, format
    "cost_m": ("cost, m", ".2f"),
    "collision_rate": ("collisions", ".2e"),
    "snmac_rate": ("sNMACs", ".2e"),
    "near_miss_rate": ("near misses", ".2e"),
    "path_deviation_mean_m": ("mean deviation, m", ".2f"),
    "unnecessary_manoeuvre_rate": ("unnecessary manoeuvres", ".3f"),
}


class Shown:
    """Base of a result: what has `suite`, `seed`, `episodes` and `policies` with a name and metrics each."""

    suite: Any
    seed: int
    episodes: int
    policies: Any

    def __repr__(self) -> str:
        names = [scored.entry.name for scored in self.policies]
        more = f", and {len(names) - NAMES_MAX} more" if len(names) > NAMES_MAX else ""
        listed = ", ".join(name if len(name) <= 60 else name[:60] + "..." for name in names[:NAMES_MAX])
        return f"<{self.episodes} episodes of {self.suite.name}, seed {self.seed}: {listed}{more}>"

    def _repr_html_(self) -> str:
        """The table that a notebook shows: values with their 95 % intervals, the cheapest first."""
        known = {name for scored in self.policies for name in scored.metrics}
        columns = {name: form for name, form in COLUMNS.items() if name in known}
        head = "".join(f"<th>{escape(title)}</th>" for title, _ in columns.values())
        rows = []
        for scored in sorted(self.policies, key=_cost):
            cells = "".join(f"<td>{_cell(scored.metrics.get(name), form)}</td>" for name, (_, form) in columns.items())
            rows.append(f"<tr><td>{escape(scored.entry.name)}</td>{cells}</tr>")
        line = f"{self.episodes} episodes of {escape(self.suite.name)}, seed {self.seed}; 95 % intervals in brackets"
        return f"<p>{line}</p><table><tr><th>policy</th>{head}</tr>{''.join(rows)}</table>"

    def to_frame(self) -> Any:
        """A `pandas.DataFrame`: a row for each policy, and of each metric the columns NAME, NAME_low, NAME_high.

        Raises
        ------
        ParamsError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise ParamsError("to_frame needs pandas, which is not installed: pip install pandas") from error
        table: dict[str, dict[str, Any]] = {}
        for scored in self.policies:
            row = table.setdefault(scored.entry.name, {})
            for name, found in scored.metrics.items():
                row |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
        return pandas.DataFrame.from_dict(table, orient="index").rename_axis("policy")


def _cost(scored: Any) -> float:
    found = scored.metrics.get("cost_m")
    return float("inf") if found is None or found.value is None else float(found.value)


def _cell(found: Any, form: str) -> str:
    if found is None or found.value is None:
        return ""
    if found.low is None or found.high is None:
        return f"{found.value:{form}}"
    return f"{found.value:{form}} [{found.low:{form}}, {found.high:{form}}]"
