"""Path loss and noise of every link of a log, and the one channel that stands for them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from rss_gym.calibration.logs import LogRecord
from rss_gym.checks import Floats
from rss_gym.params import Channel, ParamsError
from rss_gym.radio import GaussMarkov, NoiseFit, PathLossFit, allan_curve, fit_path_loss, identify, regular

LIMITS = {item.name: (item.metadata["low"], item.metadata["high"]) for item in dataclasses.fields(Channel)}
_APART_S = 1e6  # between two records laid end to end: no noise that `Channel` knows lasts from one to the next
_SUPPORTED = 2.0  # times the variance of the residuals: more than that is not to be seen in them
_STEP_MISFIT = 0.1  # of a step, between a level and its multiple
_LEFT_OUT = 0.1  # share of the samples between gaps, unused by the Allan curve, that is worth a warning


@dataclass(frozen=True, eq=False)
class LinkFit:
    """One link: its records, and path loss factor and offset fitted to all their samples together."""

    records: tuple[LogRecord, ...]
    path_loss: PathLossFit

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(self.path_loss.residual_db)

    @property
    def distance_m(self) -> Floats:
        """True distances of all samples, m."""
        return np.concatenate([record.distance_m for record in self.records])

    @property
    def residuals_db(self) -> list[Floats]:
        """RSS minus the fitted path loss, dB, record by record."""
        ends = np.cumsum([len(record.time_s) for record in self.records])
        return np.split(self.path_loss.residual_db, ends[:-1])


@dataclass(frozen=True, eq=False)
class Fit:
    """The fitted part of a calibration.

    Parameters
    ----------
    links : dict of str to LinkFit
        The links in use.
    noise : NoiseFit
        White and Gauss-Markov noise in the residuals of all links.
    channel : Channel
        The middle link with this noise.
    excluded : dict of str to str
        Links left out, and why.
    warnings : tuple of str
        Sentences on what the records cannot tell.
    """

    links: dict[str, LinkFit]
    noise: NoiseFit
    channel: Channel
    excluded: dict[str, str]
    warnings: tuple[str, ...]

    @property
    def records(self) -> list[LogRecord]:
        """The records in use."""
        return [record for link in self.links.values() for record in link.records]

    def channel_of(self, link: str) -> Channel:
        """The channel with the path loss factor and offset of one link; as it is for a link that was not fitted."""
        return self._channels.get(link, self.channel)

    def range_prior_of(self, link: str) -> tuple[float, float]:
        """Median and standard deviation of the fitted distances, m: of one link, or of all for one that is new."""
        return self._range_priors.get(link, self._range_prior)

    @cached_property
    def _channels(self) -> dict[str, Channel]:
        fits = {name: link.path_loss for name, link in self.links.items()}
        return {
            name: self.channel.replace(path_loss_factor=fit.path_loss_factor, offset_dbm=fit.offset_dbm)
            for name, fit in fits.items()
        }

    @cached_property
    def _range_priors(self) -> dict[str, tuple[float, float]]:
        return {name: _middle_and_spread(link.distance_m) for name, link in self.links.items()}

    @cached_property
    def _range_prior(self) -> tuple[float, float]:
        return _middle_and_spread(np.concatenate([record.distance_m for record in self.records]))


def _middle_and_spread(values: Floats) -> tuple[float, float]:
    return float(np.median(values)), float(values.std())


def fit(records: Sequence[LogRecord]) -> Fit:
    """Calibrate a channel.

    Per link, path loss factor and offset together by least squares; then white and coloured noise from the Allan curve
    of all residuals; then the standard errors of the first two, which depend on that noise. The channel has the median
    factor of the links, and the offset that gives their median RSS at the middle distance (the mean of log d): the
    medians of factor and offset by themselves would be a line far from all of theirs.

    Raises
    ------
    ParamsError
        If no link can be used, or the residuals are too short or too still for an Allan curve.
    """
    links, excluded = _links(records)
    noise, warnings = _noise(links)
    links = {name: LinkFit(link.records, _path_loss(link.records, noise)) for name, link in links.items()}
    channel, clipped = _channel(links, noise)
    return Fit(links, noise, channel, excluded, (*noise.warnings, *warnings, *clipped))


def _links(records: Sequence[LogRecord]) -> tuple[dict[str, LinkFit], dict[str, str]]:
    """Every link fitted without regard to its noise; those that cannot be used, with the reason."""
    links: dict[str, LinkFit] = {}
    excluded: dict[str, str] = {}
    for name in dict.fromkeys(record.link for record in records):
        own = tuple(record for record in records if record.link == name)
        try:
            path_loss = _path_loss(own)
            for field in ("path_loss_factor", "offset_dbm"):
                value, (low, high) = getattr(path_loss, field), LIMITS[field]
                if not low <= value <= high:
                    raise ParamsError(f"{field} = {value:.3g} is outside [{low:g}, {high:g}]")
            links[name] = LinkFit(own, path_loss)
        except ParamsError as error:
            excluded[name] = str(error)
    if not links:
        reasons = "; ".join(f"link {name!r}: {reason}" for name, reason in list(excluded.items())[:3])
        sources = ", ".join(repr(source) for source in list(dict.fromkeys(record.source for record in records))[:3])
        raise ParamsError(f"no link can be calibrated: {reasons}; in log {sources}")
    return links, excluded


def _path_loss(records: Sequence[LogRecord], noise: NoiseFit | None = None) -> PathLossFit:
    return fit_path_loss(
        np.concatenate([record.distance_m for record in records]),
        np.concatenate([record.rss_dbm for record in records]),
        _end_to_end([record.time_s for record in records]),
        noise,
    )


def _end_to_end(times_s: Sequence[Floats]) -> Floats:
    """One rising time axis for several records, far apart."""
    starts = np.cumsum([0.0, *(time_s[-1] - time_s[0] + _APART_S for time_s in times_s[:-1])])
    return np.concatenate([time_s - time_s[0] + start for time_s, start in zip(times_s, starts, strict=True)])


def _noise(links: dict[str, LinkFit]) -> tuple[NoiseFit, list[str]]:
    residuals = [residual for link in links.values() for residual in link.residuals_db]
    times = [record.time_s for link in links.values() for record in link.records]
    try:
        pieces, period_s = regular(_end_to_end(times), np.concatenate(residuals))
        noise = identify(allan_curve(pieces, period_s))
    except ParamsError as error:
        raise ParamsError(f"{_where(links)}: the noise cannot be told from the times and residuals: {error}") from error
    spans = sum(time_s[-1] - time_s[0] for time_s in times)
    left_out = 1.0 - sum(map(len, pieces)) * period_s / max(spans, period_s)
    if left_out > _LEFT_OUT:
        return noise, [f"{left_out:.0%} of the time lies in gaps or between them and is not in the Allan curve"]
    return noise, []


def _where(links: dict[str, LinkFit]) -> str:
    """`log 'a.csv', links 'x' and 'y'`: what an error is about."""
    sources = list(dict.fromkeys(record.source for link in links.values() for record in link.records))
    named = [
        f"{what}{'s' if len(all_) > 1 else ''} {', '.join(map(repr, all_[:3]))}"
        for what, all_ in (("log", sources), ("link", list(links)))
    ]
    return ", ".join(named)


def _channel(links: dict[str, LinkFit], noise: NoiseFit) -> tuple[Channel, list[str]]:
    coloured, told = _supported(links, noise)
    factors = np.array([link.path_loss.path_loss_factor for link in links.values()])
    offsets = np.array([link.path_loss.offset_dbm for link in links.values()])
    middle_db = 10.0 * np.mean(np.log10(np.concatenate([link.distance_m for link in links.values()])))
    factor = float(np.median(factors))
    steps = [_step_db(np.concatenate([record.rss_dbm for record in link.records])) for link in links.values()]
    weights = np.array([link.rows for link in links.values()])
    step_db = max(set(steps), key=lambda step: int(weights[np.array(steps) == step].sum()))
    wanted = {
        "path_loss_factor": factor,
        "offset_dbm": float(np.median(offsets - factors * middle_db)) + factor * middle_db,
        # The channel rounds by itself: the error of rounding is not white noise twice.
        "white_variance_db2": max(noise.white_variance_db2 - step_db**2 / 12.0, 0.0),
        "coloured_variance_db2": coloured.variance_db2,
        "coloured_tc_s": coloured.tc_s,
        "path_loss_wander": 0.0,  # its effect is in the residual, hence in the noise above
        "quantisation_db": step_db,
    }
    values: dict[str, Any] = {}
    clipped = []
    for name, value in wanted.items():
        low, high = LIMITS[name]
        values[name] = min(max(value, low), high)
        if values[name] != value:
            clipped.append(f"{name} = {value:.3g} is outside [{low:g}, {high:g}] and is written as {values[name]:g}")
    return Channel(**values), told + clipped


def _supported(links: dict[str, LinkFit], noise: NoiseFit) -> tuple[GaussMarkov, list[str]]:
    """The coloured noise, if its variance is one that the residuals show.

    Records far shorter than Tc fix only the ratio S / Tc, the growth of a random walk; S itself can come out anywhere.
    """
    residual_db = np.concatenate([link.path_loss.residual_db for link in links.values()])
    shown_db2 = float(residual_db @ residual_db) / len(residual_db)
    if noise.coloured_variance_db2 <= _SUPPORTED * shown_db2:
        return noise.noise, []
    ratio = shown_db2 / noise.coloured_variance_db2
    told = (
        f"the records are too short for the coloured variance: {noise.coloured_variance_db2:.3g} dB^2 came out, where "
        f"the residuals show {shown_db2:.3g}; the channel has the latter, and the correlation time in the same ratio"
    )
    return GaussMarkov(shown_db2, noise.coloured_tc_s * ratio), [told]


def _step_db(rss_dbm: Floats) -> float:
    """The step of which all RSS are multiples, apart from a common shift; 0 if there is none.

    The least distance of two levels, made exact level by level: a step of 1/1.9 dB written with two digits is found
    too.
    """
    levels = np.unique(np.round(rss_dbm, 6))
    if not 2 <= len(levels) <= len(rss_dbm) // 4:  # values hardly ever come twice: not rounded
        return 0.0
    gaps = np.diff(levels)
    step, number = float(gaps.min()), np.zeros(len(levels))
    for k in range(1, len(levels)):
        number[k] = number[k - 1] + max(round(gaps[k - 1] / step), 1)
        step = float((levels[k] - levels[0]) / number[k]) if k > 2 else step
    misfit = np.abs(levels - levels[0] - number * step).max() / step
    return float(np.round(step, 4)) if misfit < _STEP_MISFIT else 0.0
