"""The sensor of one vehicle on one road: numbers the others, ranges them at every tick, keeps what was heard."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import state, variants
from rss_gym.highway import links
from rss_gym.jit import announce
from rss_gym.params import Params, ParamsError
from rss_gym.physics.random import uniform
from rss_gym.sensed import OTHER, OWN
from rss_gym.streams import ROAD_VEHICLES, STREAM_EPISODE

CAPACITY = 32  # vehicles at first; doubled when more appear


class Sensor:
    """State of the radio in one episode.

    Parameters
    ----------
    params : Params
        Of `rss_gym.highway.params`.
    radio_range_m : float
        Beyond it nobody is heard.

    Attributes
    ----------
    episode : record of EPISODE
        Events on true states, for scores.
    """

    def __init__(self, params: Params, radio_range_m: float) -> None:
        announce(Path(__file__).resolve().parents[1])
        self.params, self.radio_range_m = params, radio_range_m
        self._config, self._channels = state.config(params), state.channels(params)
        self._block, self._link_lanes = np.zeros(1, state.BLOCK), np.zeros(1, state.LINK_LANES)
        self._agent_lanes, self._other_lanes = np.zeros((2, 1), state.AIRCRAFT_LANES)
        self._contact_lanes, self._own = np.zeros(1, state.CONTACT_LANES), np.zeros(1, OWN)
        self._episode = np.zeros(1, state.EPISODE)
        self._states: list[tuple[float, ...]] = []  # as `links.update_radio` takes them
        self._roads: list[tuple[float, ...]] = []
        self._ticks = 0  # that `_update_radio` has run over
        self._numbers: dict[Any, int] = {}
        self._allocate(CAPACITY)

    @property
    def episode(self) -> Any:
        """One record of EPISODE."""
        self._update_radio()
        return self._episode[0]

    @property
    def now_s(self) -> float:
        """Time since the start of the episode."""
        return max(self._ticks + len(self._roads) - 1, 0) * self.params.clock.tick_s

    @property
    def vehicles(self) -> np.ndarray:
        """The agent and those that have appeared so far, in the order of their numbers: (1 + n,) VEHICLE."""
        self._update_radio()
        return self._vehicles[: 1 + len(self._numbers)]

    @property
    def range_m(self) -> np.ndarray:
        """Estimated ranges of the vehicles (n,), where heard."""
        self._update_radio()
        return self._links["range_m"][: len(self._numbers)]

    def start(self, road: Any, agent: Any, split: int, seed: int, number: int, key: int) -> None:
        """Begin an episode, with its first measurement."""
        self._states.clear()
        self._roads.clear()
        self._ticks = 0
        self._episode[:] = np.zeros(1, state.EPISODE)
        e = self._episode[0]
        e["split"], e["seed"], e["number"], e["key"] = split, seed, number, key
        e["channel"] = min(
            int(uniform(np.uint64(key), STREAM_EPISODE, 0) * len(self._channels)), len(self._channels) - 1
        )
        e["min_separation_m"], e["warned_s"] = np.inf, -1.0
        self._key = np.uint64(key)
        self._channel = self._channels[e["channel"] : e["channel"] + 1]
        self._numbers = {}
        self._agent = agent
        self._allocate(CAPACITY)
        self._log(road)

    def tick(self, road: Any) -> None:
        """After a step of the simulation."""
        self._log(road)

    def log(self, vehicles: list[Any], states: np.ndarray, roads: np.ndarray) -> None:
        """After some steps of the simulation: what `tick` writes down of each.

        Parameters
        ----------
        vehicles : list
            Of the road.
        states : (ticks, n, 4) array
            Their x (m), y (m), heading (rad) and speed (m/s) after each step.
        roads : (ticks, 3) array
            Direction of the agent's lane (cosine, sine), and how far (m) the agent is to the right of its centre.
        """
        self._update_radio()
        ticks, n, _ = states.shape
        logged = np.empty((ticks, n, 5))
        logged[..., 0], logged[..., 1:] = [self._number(vehicle) for vehicle in vehicles], states
        ends = n * np.arange(1.0, ticks + 1.0)
        self._run(logged.reshape(ticks * n, 5), np.column_stack([ends, roads]))

    def advance_slow_noise(self) -> None:
        """Before the ticks of a decision: advance the slow processes."""
        decision = int(self.episode["tick"]) // self.params.clock.ticks_per_decision
        vehicles = self.vehicles
        links.advance_slow_noise(
            self._config, self._channel, self._key, decision, vehicles, self._links[: len(vehicles) - 1]
        )

    def sense(self) -> tuple[np.ndarray, np.ndarray]:
        """What the agent knows: OWN, and OTHER of every vehicle that is heard, nearest (as estimated) first."""
        others = self.sense_all()
        heard = others[others["present"]]
        return self._own, heard[np.argsort(heard["range_m"], kind="stable")]

    def sense_all(self) -> np.ndarray:
        """OTHER of every vehicle that has appeared so far, in the order of their numbers, heard or not."""
        vehicles = self.vehicles
        n = len(vehicles) - 1
        others = np.zeros(n, OTHER)
        links.sense(
            self._config, self._channel, self._episode, vehicles, self._links[:n], self._contacts[:n], self._own, others
        )
        return others

    def _log(self, road: Any) -> None:
        """Write down the states of all that is on the road, for `_update_radio`."""
        agent, states = self._agent, self._states
        for vehicle in road.vehicles:
            position = vehicle.position
            states.append((self._number(vehicle), position[0], position[1], vehicle.heading, vehicle.speed))
        along_m, offset_m = agent.lane.local_coordinates(agent.position)
        heading = agent.lane.heading_at(along_m)
        self._roads.append((len(states), cos(heading), sin(heading), offset_m))

    def _number(self, vehicle: Any) -> int:
        """Its row in `vehicles`; one that appears gets the next."""
        if vehicle is self._agent:
            return 0
        return self._numbers.setdefault(vehicle, len(self._numbers) + 1)

    def _update_radio(self) -> None:
        """Run the radio over the ticks written down: at once, which is many times cheaper than one at a time."""
        if not self._roads:
            return
        states, roads = np.array(self._states), np.array(self._roads)
        self._states.clear()
        self._roads.clear()
        self._run(states, roads)

    def _run(self, states: np.ndarray, roads: np.ndarray) -> None:
        """Run the radio over ticks, as `links.update_radio` takes them."""
        rows = 1 + len(self._numbers)
        while rows > len(self._vehicles):
            self._grow()
        variants.radio(links.update_radio, self.params.ranging.estimator)(
            self._config, self._channel, self._key, self.radio_range_m, self.params.zone.range_error_m, states, roads,
            self._ticks, self._episode, self._vehicles[:rows], self._links[: rows - 1], self._contacts[: rows - 1],
            self._block, self._agent_lanes, self._other_lanes, self._contact_lanes, self._link_lanes,
        )  # fmt: skip
        self._ticks += len(roads)

    def _allocate(self, size: int) -> None:
        """Room for an agent and `size` - 1 others, of whom nothing is known."""
        self._vehicles = np.zeros(size, links.VEHICLE)
        self._links, self._contacts = np.zeros(size, state.LINK), np.zeros(size, state.CONTACT)

    def _grow(self) -> None:
        """Room for twice as many, as long as each has noise of its own."""
        before, size = (self._vehicles, self._links, self._contacts), len(self._vehicles)
        if 2 * size > ROAD_VEHICLES:
            raise ParamsError(f"a road holds at most {ROAD_VEHICLES} vehicles over one drive, the agent among them")
        self._allocate(2 * size)
        for new, old in zip((self._vehicles, self._links, self._contacts), before, strict=True):
            new[:size] = old
