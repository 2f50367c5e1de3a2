"""Rare encounters are flown more often than they are drawn, and weighed down by as much: an importance sampler."""

from __future__ import annotations

from collections import deque

import numpy as np

from rss_gym.core import Batch


class NearMisses:
    """Encounters in which earlier flights came near, from which a share of the rows is drawn.

    A flight whose encounter has the density p is drawn from q = (1 - s) p, and from q = (1 - s) p + s p / h where it
    came nearer than the limit: s is the share of the rows, h the share of new encounters that come so near. Its weight
    is p / q (the balance heuristic of Veach and Guibas 1995), so that the mean over all rows is that of new encounters.

    Parameters
    ----------
    share : float
        s, below 1; 0 flies new encounters alone.
    limit_m : float
        Separation below which an encounter is remembered.
    size : int
        Encounters that are remembered, the latest ones.
    """

    def __init__(self, share: float, limit_m: float, size: int = 4096) -> None:
        self.share, self.limit_m = share, limit_m
        self._known: deque[tuple[int, int, int]] = deque(maxlen=size)  # seed, number, new encounters flown before it
        self._flown = self._new = 0  # new encounters: in all, and in the rows that fly now

    @property
    def rarity(self) -> float:
        """h, over the new encounters since the oldest one that is remembered."""
        return len(self._known) / max(1, self._flown - self._known[0][2]) if self._known else 0.0

    def reset(self, batch: Batch, draws: np.random.Generator) -> None:
        """Start an episode in every row; the last rows of the batch fly what is remembered, the others go on."""
        again = self._again(batch.n)
        rows = slice(batch.n - again, batch.n)
        seeds, numbers = batch.seeds[rows].copy(), batch.numbers[rows].copy()
        chosen = draws.integers(len(self._known), size=again) if again else ()
        for row, which in enumerate(chosen, batch.n - again):
            batch.seeds[row], batch.numbers[row], _ = self._known[which]
        batch.reset(np.ones(batch.n, bool))
        batch.seeds[rows], batch.numbers[rows] = seeds, numbers
        self._new = batch.n - again

    def weigh(self, batch: Batch, least_m: np.ndarray) -> np.ndarray:
        """Weights (n,) of flights with these least separations (n,); new ones that came near are remembered."""
        near, share = least_m < self.limit_m, 1.0 - self._new / batch.n
        near[self._new :] = True  # drawn as such, however they ended this time
        weights = np.full(batch.n, 1.0 / (1.0 - share))
        if share:
            weights[near] = 1.0 / (1.0 - share + share / self.rarity)
        for row in np.flatnonzero(near[: self._new]):
            e = batch.episode[row]
            self._known.append((int(e["seed"]), int(e["number"]), self._flown))
        self._flown += self._new
        return weights

    def _again(self, n: int) -> int:
        """Rows that fly again, once there are as many encounters to choose from."""
        again = int(self.share * n)
        return again if len(self._known) >= again else 0
