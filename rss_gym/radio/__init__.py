"""The radio outside the world: logs, their noise by Allan variance, and channels to fly.

From a log to a channel: `fit_path_loss` gives path loss factor, offset and residual; `regular` puts the residual on a
constant period; `allan_curve` and `identify` find its white and its Gauss-Markov part; `fit_path_loss` with that noise
gives standard errors that know the residual is coloured; `save_channel` writes the file that
`rss_gym.params.load_channel` reads.
"""

from rss_gym.radio.allan import AllanCurve, allan_curve, allan_model
from rss_gym.radio.channel_file import save_channel
from rss_gym.radio.gauss_markov import GaussMarkov
from rss_gym.radio.identify import NoiseFit, identify
from rss_gym.radio.path_loss import PathLossFit, distance, fit_path_loss, received
from rss_gym.radio.regular import regular
from rss_gym.radio.simulate import RadioLog, simulate
from rss_gym.radio.two_point import Autocovariance, TwoPoint, autocovariance, two_point

__all__ = [
    "AllanCurve",
    "Autocovariance",
    "GaussMarkov",
    "NoiseFit",
    "PathLossFit",
    "RadioLog",
    "TwoPoint",
    "allan_curve",
    "allan_model",
    "autocovariance",
    "distance",
    "fit_path_loss",
    "identify",
    "received",
    "regular",
    "save_channel",
    "simulate",
    "two_point",
]
