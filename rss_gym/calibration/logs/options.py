"""How a log is to be read where it does not say so itself."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field

from rss_gym.params import Group, ParamsError, choice, number, of_kind
from rss_gym.schema import listed, optional, real

TIME_UNITS: dict[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@dataclass(frozen=True)
class ReadOptions(Group):
    """What a user may say about logs.

    Parameters
    ----------
    columns : mapping of str to str
        What is in which column of a table or field of a bag, see `rss_gym.calibration.logs.columns.NAMES`.
    time_unit : str, optional
        s, ms, us or ns; by default it is found.
    melt : str, optional
        For tables with a column for each link: `*` to find these columns, or patterns such as `rss=rss_*,dist=d_*`
        whose star is the link's name.
    truth : path, optional
        Table with the true distances or positions over the same clock.
    offset_db : float
        Added to every RSS: for receivers that report a power relative to an unknown level.
    station : tuple of 3 floats, optional
        Where the fixed end is: latitude, longitude in degrees and altitude in m, or x, y, z in m.
    from_s, to_s : float
        The rows used, in s after the first of each file.
    whole : bool
        Use rows on the ground and while not armed too.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    time_unit: str | None = choice(None, TIME_UNITS)
    melt: str | None = None
    truth: str | os.PathLike[str] | None = None
    offset_db: float = number(0.0, -1000.0, 1000.0)
    station: tuple[float, float, float] | None = of_kind(None, optional(listed(3, 3, "three finite numbers", real())))
    from_s: float = -math.inf
    to_s: float = math.inf
    whole: bool = False

    def __post_init__(self) -> None:
        """Check what can be checked without a log.

        Raises
        ------
        ParamsError
            For an unknown unit, a number that is not finite, or an empty span of time.
        """
        Group.__post_init__(self)
        if not self.from_s < self.to_s:
            raise ParamsError(f"--from must lie before --to, got {self.from_s:g} and {self.to_s:g} s")
