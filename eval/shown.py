"""How a result shows itself: one line, a table for notebooks, and a data frame."""

from __future__ import annotations

from typing import Any

from rss_gym.eval.columns import columns_of
from rss_gym.pages.markup import renderer
from rss_gym.pages.table import Table
from rss_gym.params import ParamsError

render = renderer(__file__)
NAMES_MAX = 8  # policies that the line names


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
        columns = {name: column for name, column in columns_of(self.suite.params).items() if name in known}
        rows = (
            [scored.entry.name, *(scored.metrics.get(name) for name in columns)]
            for scored in sorted(self.policies, key=_cost)
        )
        return str(render("shown.html", result=self, table=Table(["policy", *columns.values()], rows)))

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
