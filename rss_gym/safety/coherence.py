"""How many independent looks the channel allows, (38)-(39)."""

import numpy as np
import numpy.typing as npt

from rss_gym.checks import together
from rss_gym.safety.zone import miss_probability

LIGHT_MPS = 3.0e8  # as rounded in the paper's figures, 0.07 % above the defined value


def coherence_s(speed_mps: npt.ArrayLike, frequency_hz: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Coherence time T_d (s) of the channel between two aircraft that both fly at `speed_mps`.

    sqrt(9 / (16 pi)) / f_D with the Doppler shift f_D = 2 v f / c of the relative speed 2 v. At 2.5 GHz and 1, 2 and
    3 m/s it gives the figures above (39), 25.39, 12.69 and 8.46 ms; at the paper's own 2.462 GHz and 1 m/s it is 25.78
    ms. It is the time scale of the fast fading: the slow noise of Sec. III repeats for longer, see `correlated_zone`.

    Parameters
    ----------
    speed_mps, frequency_hz : array_like
        Speed of each aircraft and carrier frequency, > 0.
    """
    speed, frequency = together(speed_mps=(speed_mps, 1e-9), frequency_hz=(frequency_hz, 1.0))
    return np.sqrt(9.0 / (16.0 * np.pi)) * LIGHT_MPS / (2.0 * speed * frequency)


def trials_max(coherence_s: npt.ArrayLike, observed_s: npt.ArrayLike = 1.0) -> npt.NDArray[np.int64]:
    """N_d of (38): most independent looks in `observed_s` (a second, in the paper), the whole part of 1 / T_d.

    (39) states about 40 for 25.39 ms, rounded up; the whole part is 39.
    """
    coherence, observed = together(coherence_s=(coherence_s, 1e-9), observed_s=(observed_s, 0.0))
    return np.floor(observed / coherence).astype(np.int64)[()]


def least_miss_probability(
    range_error_probability: npt.ArrayLike, coherence_s: npt.ArrayLike, observed_s: npt.ArrayLike = 1.0
) -> npt.NDArray[np.float64]:
    """(38): the miss probability of as many looks as the channel allows; no fewer than one is taken."""
    return miss_probability(range_error_probability, np.maximum(trials_max(coherence_s, observed_s), 1))
