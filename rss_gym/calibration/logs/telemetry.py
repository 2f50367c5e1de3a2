"""What the logs of autopilots have in common: radio reports, positions, a home, and when the aircraft flew."""

from __future__ import annotations

from array import array
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rss_gym.calibration.logs.ends import jumps, known_places, rate_mps, relative_m, sign
from rss_gym.calibration.logs.options import ReadOptions
from rss_gym.calibration.logs.record import (
    COPY,
    NEAREST_M,
    NO_POSITION,
    NOT_ARMED,
    ON_GROUND,
    ROWS_MAX,
    ROWS_MIN,
    TOO_NEAR,
    USED,
    Floats,
    LogFile,
    Rows,
)
from rss_gym.params import ParamsError

GAP_MAX_S = 2.0  # between the positions on both sides of a radio report
HEIGHT_M, STILL_MPS = 2.0, 1.0  # an aircraft below both stands on the ground
COPY_S = 0.5  # between two kinds of message that carry one report
TWIN_S = 0.05  # between two packets of one kind that came by two ways
_COPIES = 0.8  # share of a sender's reports that another sent too
_BACK_S = 1e-6


def sik_dbm(raw: Floats) -> Floats:
    """RSS of a SiK radio's 8-bit report: raw / 1.9 - 127 (ArduPilot's wiki); 0 and 255 say that there is none: NaN."""
    return np.where((raw > 0.0) & (raw < 255.0), raw / 1.9 - 127.0, np.nan)


@dataclass(eq=False)
class Telemetry:
    """What was taken from the messages of one log; times are the log's own, in s.

    Attributes
    ----------
    source, format : str
        Name of the file, and of its format.
    links : tuple of str
        What the two powers of a report are.
    reports : dict of str to array
        By sender: time, both powers in dBm, whatever tells a copy from another report, number and kind of the message.
    positions : dict of str to array
        By vehicle: time, latitude, longitude, altitude, velocity east, north, up (NaN where there is none), height
        above home (NaN where there is none).
    homes : array
        Time, latitude, longitude, altitude.
    armed, landed : array
        Time, and 1 or 0.
    """

    source: str
    format: str
    links: tuple[str, ...] = ("ground", "aircraft")
    reports: dict[str, array[float]] = field(default_factory=lambda: defaultdict(lambda: array("d")))
    positions: dict[str, array[float]] = field(default_factory=lambda: defaultdict(lambda: array("d")))
    homes: array[float] = field(default_factory=lambda: array("d"))
    armed: array[float] = field(default_factory=lambda: array("d"))
    landed: array[float] = field(default_factory=lambda: array("d"))
    notes: list[str] = field(default_factory=list)

    def report(
        self, sender: str, time_s: float, powers: tuple[float, float], mark: float, number: float, kind: float = 0.0
    ) -> None:
        """Keep a report of both ends' RSS."""
        self.reports[sender].extend((time_s, *powers, mark, number, kind))
        self._bound(self.reports[sender], 6)

    def position(
        self, vehicle: str, time_s: float, place: tuple[float, float, float], velocity: tuple[float, float, float],
        height_m: float = float("nan"),
    ) -> None:  # fmt: skip
        """Keep where the vehicle was."""
        self.positions[vehicle].extend((time_s, *place, *velocity, height_m))
        self._bound(self.positions[vehicle], 8)

    def _bound(self, values: array[float], width: int) -> None:
        if len(values) > width * ROWS_MAX:
            raise ParamsError(f"log {self.source!r} has more than {ROWS_MAX:,} messages; split it")

    def file(self, options: ReadOptions, lacking: tuple[str, str]) -> LogFile:
        """The rows of every link, with distances and range rates.

        Parameters
        ----------
        options : ReadOptions
            The station, and whether rows on the ground count.
        lacking : tuple of str
            What the messages of reports and of positions are called, for the error.

        Raises
        ------
        ParamsError
            Without reports or positions, or when several vehicles report positions.
        """
        track = self._track(lacking[1]) if self.reports else None
        if track is None:
            what = lacking[0] if not self.reports else f"{lacking[1]} with a position"
            raise ParamsError(f"log {self.source!r} holds no message {what}; both are needed")
        file = LogFile(self.source, self.format, [], "message", self.notes)
        file.columns = {"rss": lacking[0], "positions": lacking[1]}
        rising = self._rising(track)
        senders = self._copies_marked(rising)
        for sender, (table, copy) in senders.items():
            home = self._homes_at(table[:, 0], track, options)
            relative, known = self._relative(table[:, 0], track, home)
            distance_m = np.linalg.norm(relative, axis=1)
            velocity, moving = self._velocity(table[:, 0], track)
            rate = rate_mps(relative, velocity) if moving else None
            ground = np.zeros(len(table), np.uint8) if options.whole else self._not_flying(table[:, 0], track, home)
            for k, link in enumerate(self.links):
                rows = Rows(
                    link=link if len(senders) == 1 else f"{link} {sender}",
                    number=table[:, 4].copy(),
                    time_s=table[:, 0].copy(),
                    rss_dbm=table[:, 1 + k].copy(),
                    distance_m=distance_m.copy(),
                    range_rate_mps=None if rate is None else rate.copy(),
                    reason=np.zeros(len(table), np.uint8),
                    sender=sender,
                )
                if np.isnan(rows.rss_dbm).all() and len(self.links) > 1:
                    continue  # an end that reports nothing
                rows.drop(copy, COPY)
                rows.drop(~known, NO_POSITION)
                self._drop_ground(rows, ground)
                rows.drop(distance_m < NEAREST_M, TOO_NEAR)
                file.rows.append(rows)
        return file

    def _drop_ground(self, rows: Rows, ground: NDArray[np.uint8]) -> None:
        """Rows on the ground, unless hardly any would be left: then the log's mode or altitude is not one to go by."""
        for reason, what in ((NOT_ARMED, "never armed"), (ON_GROUND, "never off the ground")):
            flying = (rows.reason == USED) & (ground != reason)
            if flying.sum() >= ROWS_MIN:
                rows.drop(ground == reason, reason)
            elif ((rows.reason == USED) & (ground == reason)).any():
                note = f"by its messages the aircraft is (almost) {what} where the radio reports: all rows are taken"
                if note not in self.notes:
                    self.notes.append(note)

    def _track(self, name: str) -> Floats | None:
        """The positions of the one vehicle, in order, without those that cannot be."""
        tables = {vehicle: np.frombuffer(values).reshape(-1, 8) for vehicle, values in self.positions.items()}
        good = {vehicle: table[known_places(*table[:, 1:4].T)] for vehicle, table in tables.items()}
        unknown = sum(len(table) for table in tables.values()) - sum(map(len, good.values()))
        if unknown:
            self.notes.append(f"{unknown} messages {name} left out: not finite, off the globe, or beside 0, 0: no fix")
        good = {vehicle: table for vehicle, table in good.items() if len(table)}
        if not good:
            return None
        if len(good) > 1:
            raise ParamsError(
                f"log {self.source!r} holds positions of several vehicles, systems {', '.join(sorted(good))}; it "
                "must be "
                "known which one the radio is on, so give a log with one"
            )
        (track,) = good.values()
        track = self._in_order(track, f"messages {name}")
        wrong = jumps(track[:, 0], relative_m(track[:, 1:4], track[:1, 1:4].repeat(len(track), 0), True))
        if wrong.any():
            self.notes.append(f"{wrong.sum()} messages {name} left out: no flight goes there from both neighbours")
        return track[~wrong]

    def _in_order(self, table: Floats, what: str) -> Floats:
        """Rows of rising time; those stamped before an earlier one are left out."""
        latest = np.maximum.accumulate(table[:, 0])
        back = table[:, 0] < latest - _BACK_S
        if back.mean() > 0.5 if len(table) else False:
            raise ParamsError(f"log {self.source!r}: the clock goes back for most {what}; give a log of one session")
        table = table[~back]
        return table[np.diff(table[:, 0], prepend=-np.inf) > 0.0]

    def _rising(self, track: Floats) -> dict[str, Floats]:
        return {sender: np.frombuffer(values).reshape(-1, 6) for sender, values in self.reports.items() if len(values)}

    def _copies_marked(self, reports: dict[str, Floats]) -> dict[str, tuple[Floats, NDArray[np.bool_]]]:
        """Every sender's reports, and which of them repeat another message of the same report.

        Within a sender, a report of the same numbers in another kind of message within half a second, or in the same
        kind within a twentieth. A sender most of whose reports another sent too only passed them on: it is left out.
        """
        kept: dict[str, tuple[Floats, NDArray[np.bool_]]] = {}
        for sender, table in sorted(reports.items(), key=lambda item: -len(item[1])):
            passed = next((other for other, (first, _) in kept.items() if _same(table, first) >= _COPIES), None)
            if passed is not None:
                self.notes.append(f"sender {sender} passes on the reports of {passed}: its {len(table)} are left out")
                continue
            kept[sender] = (table, _copies(table))
        if len(kept) > 1:
            self.notes.append(f"{len(kept)} senders report the radio: a link for each")
        return kept

    def _homes_at(self, at_s: Floats, track: Floats, options: ReadOptions) -> Floats:
        """(n, 3): where the ground station is at each time."""
        if options.station is not None:
            return np.tile(np.array(options.station), (len(at_s), 1))
        homes = np.frombuffer(self.homes).reshape(-1, 4)
        homes = homes[known_places(*homes[:, 1:].T)] if len(homes) else homes
        if len(homes):
            homes = homes[np.argsort(homes[:, 0], kind="stable")]
            moved = np.abs(np.diff(homes[:, 1:3], axis=0)).max(axis=1) > 1e-5 if len(homes) > 1 else np.zeros(0, bool)
            self._once(f"home moves {moved.sum()} times: each row has the home of its time" if moved.any() else "")
            place: Floats = homes[np.maximum(np.searchsorted(homes[:, 0], at_s, side="right") - 1, 0), 1:]
            return place
        armed = np.frombuffer(self.armed).reshape(-1, 2)
        took_off = armed[armed[:, 1] > 0.5][:1]
        at = int(np.searchsorted(track[:, 0], took_off[0, 0])) if len(took_off) else 0
        where = "it was first armed" if len(took_off) and 0 < at < len(track) else "its first position is"
        at = at if at < len(track) else 0
        self._once(f"no HOME_POSITION, so the ground station is taken to be where {where}; name another by --station")
        return np.tile(track[at, 1:4], (len(at_s), 1))

    def _once(self, note: str) -> None:
        if note and note not in self.notes:
            self.notes.append(note)

    @staticmethod
    def _relative(at_s: Floats, track: Floats, home: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        reference = track[:1, 1:4]
        place = relative_m(track[:, 1:4], np.repeat(reference, len(track), axis=0), True)
        own = relative_m(home, np.repeat(reference, len(home), axis=0), True)
        after = np.searchsorted(track[:, 0], at_s)
        later, earlier = np.minimum(after, len(track) - 1), np.maximum(after - 1, 0)
        known = (after > 0) & (after < len(track)) & (track[later, 0] - track[earlier, 0] <= GAP_MAX_S)
        return _interpolated(at_s, track[:, 0], place) - own, known

    def _velocity(self, at_s: Floats, track: Floats) -> tuple[Floats, bool]:
        """(n, 3) east, north, up at each report, and whether the log has any; up by the altitude's own change."""
        velocity = track[:, 4:7]
        known = np.isfinite(velocity[:, :2]).all(axis=1)
        if known.sum() < max(2, 0.5 * len(track)) or not velocity[known, :2].any():
            return np.zeros((len(at_s), 3)), False
        velocity, time_s = np.nan_to_num(velocity[known]), track[known, 0]
        if sign(time_s, track[known, 3], velocity[:, 2]) < 0.0:
            velocity = velocity * np.array([1.0, 1.0, -1.0])
            self._once("the vertical velocity runs against the altitude: its sign is turned")
        return _interpolated(at_s, time_s, velocity), True

    def _not_flying(self, at_s: Floats, track: Floats, home: Floats) -> NDArray[np.uint8]:
        """For each report `NOT_ARMED`, `ON_GROUND` or 0."""
        reason = np.zeros(len(at_s), np.uint8)
        heights = track[:, 7]
        if np.isfinite(heights).mean() > 0.5 and np.nanmax(np.abs(heights)) > 0.0:
            good = np.isfinite(heights)
            height_m = np.interp(at_s, track[good, 0], heights[good])
        else:
            height_m = np.interp(at_s, track[:, 0], track[:, 3]) - home[:, 2]
        speed_mps = _speeds(at_s, track)
        reason[(height_m < HEIGHT_M) & (speed_mps < STILL_MPS)] = ON_GROUND
        reason[_at(self.landed, at_s, 0.0) > 0.5] = ON_GROUND
        reason[_at(self.armed, at_s, 1.0) < 0.5] = NOT_ARMED
        return reason


def _copies(table: Floats) -> NDArray[np.bool_]:
    """(n,) whether a report repeats one before it."""
    copy = np.zeros(len(table), bool)
    last: dict[tuple[float, ...], tuple[float, float]] = {}
    for k, (time_s, *values, _, kind) in enumerate(table.tolist()):
        key = tuple(values)
        before_s, other = last.get(key, (-np.inf, kind))
        copy[k] = 0.0 <= time_s - before_s < (COPY_S if other != kind else TWIN_S)
        if not copy[k]:
            last[key] = time_s, kind
    return copy


def _speeds(at_s: Floats, track: Floats) -> Floats:
    """Speed of the positions over about two seconds on each side."""
    place = relative_m(track[:, 1:4], np.repeat(track[:1, 1:4], len(track), axis=0), True)
    before, after = (_interpolated(at_s + shift, track[:, 0], place) for shift in (-1.0, 1.0))
    speeds: Floats = np.linalg.norm(after - before, axis=1) / 2.0
    return speeds


def _at(changes: array[float], at_s: Floats, before: float) -> Floats:
    """A step function at each time, from (time, value) pairs."""
    table = np.frombuffer(changes).reshape(-1, 2)
    if not len(table):
        return np.full(len(at_s), before)
    table = table[np.argsort(table[:, 0], kind="stable")]
    values: Floats = table[np.maximum(np.searchsorted(table[:, 0], at_s, side="right") - 1, 0), 1]
    return values


def _same(table: Floats, first: Floats) -> float:
    """Share of the rows of one sender that the other has too, within half a second."""
    times: dict[Any, list[float]] = defaultdict(list)
    for row in first.tolist():
        times[tuple(row[1:4])].append(row[0])
    hits = sum(any(abs(row[0] - at) < COPY_S for at in times.get(tuple(row[1:4]), ())) for row in table.tolist())
    return hits / max(len(table), 1)


def _interpolated(at_s: Floats, time_s: Floats, values: Floats) -> Floats:
    return np.column_stack([np.interp(at_s, time_s, column) for column in values.T])
