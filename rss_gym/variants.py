"""The world's kernels for an estimator or a tracker that has no branch of its own in them.

Those of the package are branches of one compiled world. For another part the few kernels between `reset` and `step` and
the call of the part are copied with the part in its place, and compiled once for each; the machine code is kept under a
digest of the part.
"""

import functools
from pathlib import Path

from rss_gym import links, world
from rss_gym.jit import compiled, digest_of, guarded, inner, parts_dir, rebound, rebound_kernel
from rss_gym.physics.elementary import exp, log
from rss_gym.ranging import ESTIMATORS
from rss_gym.ranging.batch import Setting
from rss_gym.ranging.estimator import functions
from rss_gym.tracking import TRACKERS

ROOT = Path(__file__).resolve().parent


def kernels(params):
    """`reset` and `step` of `rss_gym.world` with the estimator and the tracker of these parameters.

    Parameters
    ----------
    params : Params

    Returns
    -------
    tuple of two kernels
    """
    estimator, tracker = ESTIMATORS[params.ranging.estimator], TRACKERS[params.tracking.tracker]
    if estimator.code >= 0 and tracker.code >= 0:
        return world.reset, world.step
    names = (f"estimator {params.ranging.estimator!r}", f"tracker {params.tracking.tracker!r}")
    what = " and ".join(name for name, part in zip(names, (estimator, tracker), strict=True) if part.code < 0)
    return _world(estimator, tracker, what)


@functools.cache
def _world(estimator, tracker, what):
    folder = parts_dir(ROOT, digest(estimator, tracker), what)
    parts = {}
    if tracker.code < 0:
        parts["write_observations"] = rebound(world.write_observations, advance=advance_of(tracker))
    reset, step = dict(parts), dict(parts)
    if estimator.code < 0:
        reset["start_filter"], step["estimate"] = lanes_of(estimator)
    made = rebound_kernel(world.reset, folder, **reset), rebound_kernel(world.step, folder, **step)
    return tuple(guarded(one, what) for one in made)


def radio(kernel, name):
    """A kernel that calls `start_filter` and `estimate` of `rss_gym.links`, for the estimator of that name."""
    estimator = ESTIMATORS[name]
    return kernel if estimator.code >= 0 else _radio(kernel, estimator, f"estimator {name!r} on a road")


@functools.cache
def _radio(kernel, estimator, what):
    start_filter, estimate = lanes_of(estimator)
    folder = parts_dir(ROOT, digest(estimator), what)
    return guarded(rebound_kernel(kernel, folder, start_filter=start_filter, estimate=estimate), what)


def digest(*parts):
    """Digest of the functions and options of estimators and trackers that have no branch of their own."""
    seen = []
    for part in parts:
        if part.code >= 0:
            seen.append(part.code)
        elif hasattr(part, "filter"):
            f = part.filter
            seen += [f.prior, f.predict, f.update, f.start, part.white_is_total, part.literal, part.logarithmic]
        else:
            seen += [part.advance, part.columns]
    return digest_of(*seen)


def advance_of(tracker):
    """`tracking.advance.advance` for one tracker."""
    one = compiled(tracker.advance)

    @inner
    def advance(code, own, other, memory, track, model):
        one(own, other, memory, track, model)

    return advance


def lanes_of(estimator):
    """`links.start_filter` and `links.estimate` for one estimator, by its filter."""
    prior, start, predict, update, _ = functions(estimator.filter)
    share = 1.0 if estimator.white_is_total else 0.0  # of the coloured noise's variance in the white one
    literal, logarithmic = estimator.literal, estimator.logarithmic
    ceiling_m = links.LS_CEILING_M

    @inner(forceinline=True)
    def setting_of(config, block, r, prior_m, prior_std_m):
        """What the filter knows on lane r."""
        unit = prior_m * prior_m if logarithmic else 1.0  # of the process noise, m^2
        return Setting(
            block.offset_dbm[r],
            block.path_loss_factor[r],
            block.white_variance_db2[r] + share * block.coloured_variance_db2[r],
            block.coloured_variance_db2[r],
            -config.tick_s / log(block.coloured_decay[r]),
            config.process_noise_m2 / config.tick_s / unit,
            config.process_noise_psi_m2 / config.tick_s / unit,
            prior_m,
            prior_std_m,
            config.range_floor_m,
            ceiling_m,
            5.0,
            literal,
        )

    @inner(forceinline=True)
    def put(config, link, r, x, phi, p_xx, p_xp, p_pp):
        """Write a state as range (m), coloured noise (dB) and their covariance."""
        d = max(exp(x) if logarithmic else x, config.range_floor_m)
        scale = d if logarithmic else 1.0
        link.range_m[r], link.coloured_hat_db[r] = d, phi
        link.p_dd[r], link.p_dp[r], link.p_pp[r] = p_xx * scale * scale, p_xp * scale, p_pp

    @inner
    def start_filter(config, block, link, to_node):
        """The filter after the first sample, or its prior where that was not received."""
        prior_m, prior_std_m = config.prior_range_m, config.prior_std_m
        if to_node:
            prior_m, prior_std_m = config.node_prior_range_m, config.node_prior_std_m
        for r in range(block.rows):
            setting, rss = setting_of(config, block, r, prior_m, prior_std_m), link.rss_dbm[r]
            x, phi, p_xx, p_xp, p_pp = prior(setting)
            if rss >= block.sensitivity_dbm[r]:
                x, phi, p_xx, p_xp, p_pp = start((x, phi, p_xx, p_xp, p_pp), rss, setting)
            put(config, link, r, x, phi, p_xx, p_xp, p_pp)

    @inner
    def estimate(config, block, link):
        """One tick of the filter, and the smoothed rate of its range."""
        gain, t, prior_m = config.rate_gain, config.tick_s, config.prior_range_m
        for r in range(block.rows):
            setting = setting_of(config, block, r, prior_m, config.prior_std_m)
            before_m, rss, noise_m2 = link.range_m[r], link.rss_dbm[r], link.process_noise_m2[r]
            x, scale = before_m, 1.0
            if logarithmic:
                x, scale, noise_m2 = log(before_m), before_m, noise_m2 / (prior_m * prior_m)
            state = (
                x, link.coloured_hat_db[r], link.p_dd[r] / (scale * scale), link.p_dp[r] / scale, link.p_pp[r]
            )  # fmt: skip
            x, phi, p_xx, p_xp, p_pp = predict(
                state, link.psi_m[r], noise_m2, block.coloured_decay[r], block.coloured_drive_db[r], setting
            )
            if rss >= block.sensitivity_dbm[r]:
                x, phi, p_xx, p_xp, p_pp = update((x, phi, p_xx, p_xp, p_pp), rss, setting)
            put(config, link, r, x, phi, p_xx, p_xp, p_pp)
            link.rate_mps[r] += gain * ((link.range_m[r] - before_m) / t - link.rate_mps[r])

    return start_filter, estimate
