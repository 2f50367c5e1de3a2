"""The error of wrong input, and how its sentence ends."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class ParamsError(ValueError):
    """A parameter that is unknown, of the wrong type, out of its range, or in contradiction with another."""


class UnknownParamError(ParamsError, TypeError):
    """A keyword that is no parameter. Other libraries try keywords of their own, and look for a TypeError."""


def suggestion(name: str, known: Iterable[str]) -> str:
    """End of an error sentence about an unknown name: the nearest known one and the list of all."""
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return (f"; did you mean {near[0]!r}?" if near else ";") + f" known: {', '.join(names)}"
