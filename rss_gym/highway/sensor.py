"""The sensor of one vehicle on one road: numbers the others, ranges them at every tick, keeps what was heard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rss_gym import records
from rss_gym.highway import links
from rss_gym.jit import announce
from rss_gym.params import Params
from rss_gym.physics.random import uniform
from rss_gym.sensed import OTHER, OWN

CAPACITY = 32  # vehicles at first; doubled when more appear


class Sensor:
    """State of the radio in one episode.

    Parameters
    ----------
    params : Params
        Of `rss_gym.highway.settings`.
    radio_range_m : float
        Beyond it nobody is heard.

    Attributes
    ----------
    episode : record of EPISODE
        Events on true states, for scores.
    """

    def __init__(self, params: Params, radio_range_m: float) -> None:
        announce(Path(__file__).resolve().parents[1])
        self.params, self.radio_range_m = params, float(radio_range_m)
        self._config, self._channels = records.config(params), records.channels(params)
        self._block, self._link_lanes = np.zeros(1, records.BLOCK), np.zeros(1, records.LINK_LANES)
        self._agent_lanes, self._craft_lanes = np.zeros((2, 1), records.AIRCRAFT_LANES)
        self._contact_lanes, self._own = np.zeros(1, records.CONTACT_LANES), np.zeros(1, OWN)
        self._episode = np.zeros(1, records.EPISODE)
        self._along = np.array([1.0, 0.0])
        self._numbers: dict[Any, int] = {}
        self._allocate(CAPACITY)

    @property
    def episode(self) -> Any:
        """One record of EPISODE."""
        return self._episode[0]

    @property
    def vehicles(self) -> np.ndarray:
        """The agent and those that have appeared so far, in the order of their numbers: (1 + n,) VEHICLE."""
        return self._vehicles[: 1 + len(self._numbers)]

    @property
    def range_m(self) -> np.ndarray:
        """Estimated ranges of the vehicles (n,), where heard."""
        return self._links["range_m"][: len(self._numbers)]

    def start(self, road: Any, agent: Any, split: int, seed: int, number: int, key: int) -> None:
        """Begin an episode, with its first measurement."""
        self._episode[:] = np.zeros(1, records.EPISODE)
        e = self.episode
        e["split"], e["seed"], e["number"], e["key"] = split, seed, number, key
        e["channel"] = min(
            int(uniform(np.uint64(key), records.STREAM_START_LINK, 8) * len(self._channels)), len(self._channels) - 1
        )
        e["min_separation_m"], e["warned_s"] = np.inf, -1.0
        self._key = np.uint64(key)
        self._channel = self._channels[e["channel"] : e["channel"] + 1]
        self._numbers = {}
        self._agent = agent
        self._allocate(CAPACITY)
        self._hear(road)

    def tick(self, road: Any) -> None:
        """After a step of the simulation."""
        self._episode["tick"] += 1
        self._hear(road)

    def decide(self) -> None:
        """Before the ticks of a decision: advance the slow processes."""
        decision = int(self.episode["tick"]) // self.params.clock.ticks_per_decision
        vehicles = self.vehicles
        links.drift(self._config, self._channel, self._key, decision, vehicles, self._links[: len(vehicles) - 1])

    def sense(self) -> tuple[np.ndarray, np.ndarray]:
        """What the agent knows: OWN, and OTHER of every vehicle that is heard, nearest (as estimated) first."""
        vehicles = self.vehicles
        n = len(vehicles) - 1
        others = np.zeros(n, OTHER)
        links.sense(
            self._config, self._channel, self._episode, vehicles, self._links[:n], self._contacts[:n], self._own, others
        )
        heard = others[others["present"]]
        return self._own, heard[np.argsort(heard["range_m"], kind="stable")]

    def _hear(self, road: Any) -> None:
        """Copy the states of all that is on the road, and run a tick of the radio."""
        agent, numbers = self._agent, self._numbers
        self._here[:] = False
        for vehicle in road.vehicles:
            if vehicle is agent:
                row = 0
            else:
                row = numbers.get(vehicle, 0)
                if row == 0:
                    row = numbers[vehicle] = len(numbers) + 1
                    if row == len(self._state):
                        self._grow()
            self._here[row] = True
            position = vehicle.position
            self._state[row] = position[0], position[1], vehicle.heading, vehicle.speed
        rows, vehicles = 1 + len(numbers), self._vehicles
        vehicles["here"][:rows] = self._here[:rows]
        for column, name in enumerate(("x_m", "y_m", "heading_rad", "speed_mps")):
            vehicles[name][:rows] = self._state[:rows, column]
        along_m, offset_m = agent.lane.local_coordinates(agent.position)
        heading = agent.lane.heading_at(along_m)
        self._along[:] = np.cos(heading), np.sin(heading)
        links.listen(
            self._config, self._channel, self._key, self.radio_range_m,
            self.params.zone.range_error_m, self._along, float(offset_m), self._episode,
            vehicles[:rows], self._links[: rows - 1], self._contacts[: rows - 1],
            self._block, self._agent_lanes, self._craft_lanes, self._contact_lanes, self._link_lanes,
        )  # fmt: skip

    def _allocate(self, size: int) -> None:
        """Room for an agent and `size` - 1 others, of whom nothing is known."""
        self._state, self._here = np.zeros((size, 4)), np.zeros(size, bool)
        self._vehicles = np.zeros(size, links.VEHICLE)
        self._links, self._contacts = np.zeros(size, records.LINK), np.zeros(size, records.CONTACT)

    def _grow(self) -> None:
        """Room for twice as many."""
        before = self._state, self._here, self._vehicles, self._links, self._contacts
        size = len(self._state)
        self._allocate(2 * size)
        for new, old in zip(
            (self._state, self._here, self._vehicles, self._links, self._contacts), before, strict=True
        ):
            new[:size] = old
