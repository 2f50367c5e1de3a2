"""Types of the options of commands and studies."""

from __future__ import annotations

import argparse
import re

_SCALES = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9}
_COUNT = re.compile(r"([+-]?\d[\d_,]*(?:\.\d+)?)(?:e\+?(\d{1,2}))?([kmg]?)", re.IGNORECASE)


def count(text: str) -> int:
    """A whole number as people write it: `10000`, `10_000`, `10,000`, `10k`, `1.5M`, `1e5`."""
    found = _COUNT.fullmatch(text.strip()) if len(text) <= 40 else None
    if found is not None:
        from decimal import Decimal

        digits, power, scale = found.groups()
        value = Decimal(re.sub("[_,]", "", digits)).scaleb(int(power or 0)) * _SCALES[scale.lower()]
        if value == value.to_integral_value():
            return int(value)
    raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number such as 10000, 10k or 1e5")
