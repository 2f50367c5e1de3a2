"""What the vector shells share: rows that are addressed like environments of their own, and a limit of steps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import Any

import numpy as np

from rss_gym.core import INFO
from rss_gym.params import ParamsError

try:
    from gymnasium.vector import AutoresetMode
except ImportError:  # Gymnasium before 1.1

    class AutoresetMode(Enum):  # type: ignore[no-redef]
        """When a row that has ended is reset, as Gymnasium names it since 1.1."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"


__all__ = ["INFOS", "AutoresetMode", "EnvRow", "EnvRows", "StepLimit", "count_of_rows"]

INFOS = (*INFO, "is_success")  # the columns of `info`


def count_of_rows(name: str, value: Any) -> int:
    """A number of rows, at least 1.

    Raises
    ------
    ParamsError
        For anything else, with the argument's name.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
        raise ParamsError(f"{name} must be a whole number >= 1, got {value!r}")
    return int(value)


class StepLimit:
    """The end of a row's episode after so many steps, as `gymnasium.wrappers.TimeLimit` ends it.

    Parameters
    ----------
    steps : int or None
        None (or -1, as in `gymnasium.make`) for no limit.
    rows : int

    Attributes
    ----------
    reached : (rows,) bool array
        EnvRows whose episode the limit has ended.
    """

    def __init__(self, steps: int | None, rows: int) -> None:
        self.steps = None if steps is None or steps == -1 else count_of_rows("max_episode_steps", steps)
        self._taken = np.zeros(rows, np.int64)
        self.reached = np.zeros(rows, bool)

    def restart(self, mask: np.ndarray) -> None:
        """A new episode begins in the rows of `mask`."""
        self._taken[mask] = 0
        self.reached[mask] = False

    def follow(self, mask: np.ndarray) -> None:
        """A step was taken in the rows of `mask`."""
        if self.steps is not None:
            self._taken += mask
            self.reached = self._taken >= self.steps


class EnvRow:
    """One environment of a batch, as `get_attr`, `set_attr` and `call` address it.

    Parameters
    ----------
    owner : vector environment
        With `params`, `batch`, `painter`, `metadata` and the spaces of a row.
    index : int
    """

    def __init__(self, owner: Any, index: int, observation_space: Any, action_space: Any) -> None:
        self._owner, self._index = owner, index
        self.params, self.render_mode, self.metadata = owner.params, owner.painter.mode, owner.metadata
        self.observation_space, self.action_space = observation_space, action_space

    @property
    def spec(self) -> Any:
        """The environment's."""
        return getattr(self._owner, "spec", None)

    @property
    def unwrapped(self) -> EnvRow:
        """Itself."""
        return self

    def info(self) -> dict[str, Any]:
        """What `info` of a step holds, of the episode that runs."""
        return {name: self._owner.batch.info(name)[self._index].item() for name in INFOS}

    def episode(self) -> dict[str, int]:
        """Which episode runs: its `seed`, its `number`, and its `split` (0 train, 1 validation, 2 suite)."""
        found = self._owner.batch.episode[self._index]
        return {name: int(found[name]) for name in ("seed", "number", "split")}

    def render(self) -> Any:
        """The row's frame (H, W, 3), a list of frames, or None without a render mode."""
        return self._owner.painter.render_row(self._owner.batch, self._index)

    def get_wrapper_attr(self, name: str) -> Any:
        """An attribute; there are no wrappers."""
        return getattr(self, name)

    def set_wrapper_attr(self, name: str, value: Any, *, force: bool = True) -> bool:
        """Set an attribute, with `force=False` only one that exists; returns whether it was set."""
        if not force and not hasattr(self, name):
            return False
        setattr(self, name, value)
        return True


class EnvRows:
    """The rows of a batch.

    Parameters
    ----------
    owner, observation_space, action_space
        As of `EnvRow`.
    count : int
    """

    def __init__(self, owner: Any, count: int, observation_space: Any, action_space: Any) -> None:
        self._rows = [EnvRow(owner, index, observation_space, action_space) for index in range(count)]

    def get(self, name: str, indices: Iterable[int]) -> list[Any]:
        """An attribute of each of the chosen rows.

        Raises
        ------
        AttributeError
            If the rows have no such attribute.
        """
        return [getattr(self._rows[index], name) for index in indices]

    def set(self, name: str, values: Sequence[Any], indices: Iterable[int]) -> None:
        """Set an attribute of the chosen rows, each to its own value.

        Raises
        ------
        ParamsError
            For `params`: rows share one world, so another one needs another environment.
        """
        if name == "params":
            raise ParamsError("params of a running environment cannot be set; make another one with the new params")
        for index, value in zip(indices, values, strict=True):
            setattr(self._rows[index], name, value)

    def call(self, name: str, indices: Iterable[int], *arguments: Any, **keywords: Any) -> list[Any]:
        """Call a method of each of the chosen rows, or read what is not a method."""
        found = self.get(name, indices)
        return [one(*arguments, **keywords) if callable(one) else one for one in found]
