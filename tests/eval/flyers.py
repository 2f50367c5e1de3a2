"""Policies for the tests of records and workers, most of them bad, named as `flyers:attribute`."""

import os
import sys
import time
from pathlib import Path

import numpy as np

from rss_gym.core import NotFiniteError
from rss_gym.params import Params

MARKS = "FLYERS_MARKS"  # environment variable: a folder where each process that flies leaves a file with its number


def mark() -> None:
    """Leave a file named by the number of this process."""
    if os.environ.get(MARKS):
        Path(os.environ[MARKS], str(os.getpid())).touch()


class Flyer:
    """Base: turns away by a recurrent function of each observation, row by row; subclasses misbehave."""

    def __init__(self, params: Params | None = None) -> None:
        self.axes = 3 if params is not None and not params.encounter.planar else 2

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        mark()
        # Memory of a row: decisions so far, then a leaky sum of the observation.
        state = np.zeros((len(observation), 2)) if state is None else state.copy()
        state[episode_start] = 0.0
        state[:, 1] = 0.9 * state[:, 1] + observation[:, 0] + observation[:, -1]
        actions = np.empty((len(observation), self.axes), np.float32)
        actions[:, :] = (state[:, 1] / (1.0 + np.abs(state[:, 1])))[:, None]
        actions = self.spoilt(actions, observation, state)
        state[:, 0] += 1.0
        return actions, state

    def spoilt(self, actions, observation, state):
        return actions


class NanOnce(Flyer):
    """Not a number at decision 9 of one encounter in about 16, by what it sees then."""

    def spoilt(self, actions, observation, state):
        drawn = np.floor(np.abs(observation).sum(axis=1) * 2.0**12).astype(np.int64) % 16 == 0
        actions[(state[:, 0] == 9.0) & drawn, 1] = np.nan
        return actions


class Raiser(Flyer):
    def spoilt(self, actions, observation, state):
        if state[0, 0] == 3.0:
            raise RuntimeError("lost\nthe way")
        return actions


class Breaker(Flyer):
    """Stands in for a world whose state is not finite, which a worker cannot be given."""

    def spoilt(self, actions, observation, state):
        raise NotFiniteError("suite", 0, 7)


class Shape(Flyer):
    def spoilt(self, actions, observation, state):
        return np.zeros((len(actions), 5))


class Ragged(Flyer):
    def spoilt(self, actions, observation, state):
        return [[0.0], [0.0, 1.0], *[[0.0, 0.0]] * (len(actions) - 2)]


class Text(Flyer):
    def spoilt(self, actions, observation, state):
        return np.full(actions.shape, "left")


class Alone(Flyer):
    """Actions without a state."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return super().predict(observation, None, episode_start)[0]


class Meddler(Flyer):
    """Changes what it was given, now and later."""

    def __init__(self, params: Params | None = None) -> None:
        super().__init__(params)
        self.given: list[np.ndarray] = []

    def spoilt(self, actions, observation, state):
        for array in (*self.given, observation):
            array[:] = 1e9
        self.given.append(observation)
        return actions

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        actions, state = super().predict(observation, state, episode_start)
        episode_start[:] = True
        self.given.append(actions)
        return actions.copy(), state


class Sleeper(Flyer):
    def spoilt(self, actions, observation, state):
        time.sleep(0.001)
        return actions


class Hang(Flyer):
    def spoilt(self, actions, observation, state):
        time.sleep(3600)
        return actions


class Exit(Flyer):
    """Ends its process at once, as a crash in a library does."""

    def spoilt(self, actions, observation, state):
        os._exit(7)


class Quit(Flyer):
    def spoilt(self, actions, observation, state):
        sys.exit(0)


class Crowd(Flyer):
    """Does what the mean of the batch says: another flight in other company."""

    def spoilt(self, actions, observation, state):
        actions[:] = np.tanh(observation.mean() - 0.5)
        return actions


class Locked(Flyer):
    """Cannot be pickled."""

    def __init__(self, params: Params | None = None) -> None:
        super().__init__(params)
        self.held = lambda: None


def gone():
    """Raise as a class does whose module is not there."""
    raise ImportError("no module named 'private'")


class Elsewhere(Flyer):
    """Can be pickled but not loaded."""

    def __reduce__(self):
        return gone, ()


def unmade(params):
    """Make no policy."""
    raise OSError("no weights at model.zip")
