"""The scales of a chart's axes: values to pixels, and round values for the ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rss_gym.pages.numbers import power_of_ten


@dataclass(frozen=True)
class Linear:
    """Values to pixels, evenly."""

    low: float
    high: float
    start_px: float
    end_px: float

    def __call__(self, value: float) -> float:
        """Pixel of a value, held inside the axis."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return self.start_px + share * (self.end_px - self.start_px)

    def ticks(self, count: int) -> list[tuple[float, str]]:
        """About so many round values, with their texts."""
        step = nice_step((self.high - self.low) / count)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [(k * step, f"{k * step:g}") for k in range(first, last + 1)]


@dataclass(frozen=True)
class Decades:
    """Values to pixels by their logarithm, over whole decades."""

    low: int
    high: int
    start_px: float
    end_px: float

    def __call__(self, value: float) -> float:
        """Pixel of a value, held inside the axis; zero lies at its low end."""
        power = math.log10(value) if value > 0.0 else -math.inf
        share = (min(max(power, self.low), self.high) - self.low) / (self.high - self.low)
        return self.start_px + share * (self.end_px - self.start_px)

    def ticks(self, count: int = 8) -> list[tuple[float, str]]:
        """The decades, every second or third one where there are many."""
        every = math.ceil((self.high - self.low) / count)
        return [(10.0**power, decade(power)) for power in range(self.high, self.low - 1, -every)]


def decade(power: int) -> str:
    """`1`, `0.1`, `0.001`, `10⁻⁴`."""
    return f"{10.0**power:g}" if -3 <= power <= 2 else power_of_ten(power)


def nice_step(length: float) -> float:
    """The smallest of 1, 2, 5, 10, 20, ... (and 0.5, 0.2, ...) that is not below `length`."""
    power: float = 10.0 ** math.floor(math.log10(max(length, 1e-12)))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= length * (1 - 1e-9))
