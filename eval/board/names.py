"""Names of entries and authors: what looks alike is alike, and some names belong to the board."""

from __future__ import annotations

import re
import unicodedata

from rss_gym import baselines
from rss_gym.baselines import road
from rss_gym.eval.suites import SUITES
from rss_gym.params import ParamsError

NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9 ._-]{0,38}[A-Za-z0-9])?")
RULE = "2 to 40 of the ASCII letters and digits, space, '.', '_' and '-', a letter or digit at both ends"
RESERVED = ("all", "board", "official", "organiser", "reference", "rss-gym", "sealed", "season", "verified", "winner")
# What a reader may take for another: after lower case, without separators.
_ALIKE = (("0", "o"), ("1", "l"), ("i", "l"), ("5", "s"), ("8", "b"), ("2", "z"), ("rn", "m"), ("vv", "w"), ("cl", "d"))


def folded(name: str) -> str:
    """The name as a careless reader sees it: names of one folding are refused beside each other."""
    text = unicodedata.normalize("NFKD", name).casefold()
    text = "".join(character for character in text if character.isalnum())
    for seen, taken in _ALIKE:
        text = text.replace(seen, taken)
    return text


def reserved() -> dict[str, str]:
    """Folded name -> the name of the board, a suite or a policy of the package that it belongs to."""
    names = [*RESERVED, *SUITES, *baselines.POLICIES, *road.POLICIES, *baselines.AGENTS]
    return {folded(name): name for name in names}


def check_name(name: str, policy: str) -> None:
    """Refuse a name that is not plain, or that imitates one of the board's.

    Parameters
    ----------
    name : str
    policy : str
        What the entry flies: a policy of the package may have its own name.

    Raises
    ------
    ParamsError
    """
    if len(name) < 2 or not NAME.fullmatch(name):
        raise ParamsError(f"name = {name[:60]!r} must be {RULE}")
    owner = reserved().get(folded(name))
    if owner is not None and not name == owner == policy:
        raise ParamsError(f"name = {name!r} is reserved: it reads like {owner!r}; choose another")
