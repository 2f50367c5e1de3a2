"""The registry of the counter-based noise streams: every draw of the package belongs to one of them, and none overlap.

A value is a function of (episode key, stream, index) alone, so it depends neither on the policy, nor on the number of
intruders, nor on how anybody is localised. A stream's first number is a constant below; the registry `STREAMS` says how
many numbers from there on belong to it. A new kind of noise is one constant and one line.

Aircraft a = 0 is the agent and a = 1..8 the intruders; intruder k is aircraft k + 1. Link g < 8 ranges the agent and
intruder g; link 8 + 4 a + j ranges aircraft a and reference node j.
"""

from typing import Final, NamedTuple

MAX_INTRUDERS: Final = 8
NODES: Final = 4  # reference nodes
LINKS: Final = MAX_INTRUDERS + NODES * (1 + MAX_INTRUDERS)
ROAD_VEHICLES: Final = 4096  # vehicles that a road may hold over one drive
ROAD_STREAMS: Final = 16  # of each of them

STREAM_TICK: Final = 0
STREAM_LOSS: Final = 100
STREAM_WANDER: Final = 200
STREAM_AIRCRAFT: Final = 300
STREAM_START_LINK: Final = 400
STREAM_START_AIRCRAFT: Final = 500
STREAM_EPISODE: Final = 600
STREAM_SAMPLER: Final = 601
STREAM_SAMPLE: Final = 602
STREAM_COMPLICATION: Final = 610
STREAM_MESSAGE: Final = 620
STREAM_ROAD: Final = 10_000


class Stream(NamedTuple):
    """Consecutive stream numbers that belong to one kind of noise."""

    start: int
    width: int
    meaning: str


STREAMS: Final = {
    "tick": Stream(STREAM_TICK, 2 * LINKS, "link g at + 2 g (coloured) and + 2 g + 1 (white); index: tick"),
    "loss": Stream(STREAM_LOSS, LINKS, "whether link g loses a packet, at + g; index: tick"),
    "wander": Stream(STREAM_WANDER, LINKS, "path loss factor of link g, at + g; index: decision"),
    "aircraft": Stream(
        STREAM_AIRCRAFT,
        10 * (1 + MAX_INTRUDERS),
        "aircraft a at + 10 a: gust (0-2), GNSS (3-5), velocity (6-8), barometer (9); index: decision",
    ),
    "start-link": Stream(STREAM_START_LINK, LINKS, "link g at + g; index: 0 coloured noise, 1 path loss factor"),
    "start-aircraft": Stream(
        STREAM_START_AIRCRAFT, 1 + MAX_INTRUDERS, "aircraft a at + a; index: as `aircraft`, and 10 barometer datum"
    ),
    "episode": Stream(STREAM_EPISODE, 1, "index: 0 channel, 1 number of intruders, 2 length of the flight"),
    "sampler": Stream(STREAM_SAMPLER, 1, "the encounter; index: as `encounters.sampler` counts its draws"),
    "sample": Stream(STREAM_SAMPLE, 1, "index 0: the decision at which the evaluator samples the range"),
    "complication": Stream(
        STREAM_COMPLICATION, MAX_INTRUDERS, "intruder k at + k; index: as in `encounters.complication`"
    ),
    "message": Stream(STREAM_MESSAGE, MAX_INTRUDERS, "whether a message of intruder k is lost, at + k; index: tick"),
    "road": Stream(STREAM_ROAD, ROAD_STREAMS * ROAD_VEHICLES, "vehicle n of a road at + 16 (n + 1), its agent n = -1"),
}
