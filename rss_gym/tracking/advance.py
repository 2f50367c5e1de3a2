"""The tracker of the world, by its code: one decision of one intruder."""

from rss_gym.jit import inner
from rss_gym.tracking import bearings, fused, latest
from rss_gym.tracking.record import BEARINGS, FUSED

bearings_advance, fused_advance, latest_advance = bearings.advance, fused.advance, latest.advance


@inner
def advance(tracker, own, other, memory, track, model):
    """Advance the track of one intruder; arguments as in `tracking.Advance`."""
    if tracker == FUSED:
        fused_advance(own, other, memory, track, model)
    elif tracker == BEARINGS:
        bearings_advance(own, other, memory, track, model)
    else:
        latest_advance(own, other, memory, track, model)
