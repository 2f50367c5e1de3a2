"""Counter-based noise: every draw is a function of (key, stream, index).

Bits come from Philox4x32-10 (Salmon, Moraes, Dror and Shaw, "Parallel Random
Numbers: As Easy as 1, 2, 3", SC11, 2011).  The 64-bit episode key is the two
32-bit Philox key words, low word first.  Value number ``index`` of a stream is
word ``index & 3`` of the block with counter ``(index >> 2, stream, 0, 0)``.

Normals are drawn by the ziggurat with 256 layers (Marsaglia and Tsang, "The
Ziggurat Method for Generating Random Variables", 2000) with separate bits for
layer and abscissa (Doornik, "An Improved Ziggurat Method to Generate Normal
Random Samples", 2005): bits 0-7 of the word are the layer, bit 31 the sign,
bits 8-30 the magnitude.  About 1.2 % of the words are not accepted at once;
attempt ``a = 1, 2, ...`` to finish value ``index`` then uses the block with
counter ``(index >> 2, stream, 4 * a + (index & 3), 0)``, which no other value
uses: its words are, in order, the test uniform, the second uniform of the tail
and the next candidate.

Stream and block numbers are taken modulo 2**32.  From interpreted code pass keys
and seeds as ``np.uint64``: Numba takes a plain ``int`` for a signed number and
refuses one of 2**63 or more.
"""

import numpy as np

from rss_gym.jit import kernel
from rss_gym.physics.elementary import exp, log

__all__ = ["episode_key", "fill_normals", "normal", "philox4x32", "uniform"]

_MULTIPLIER_0 = np.uint64(0xD2511F53)
_MULTIPLIER_1 = np.uint64(0xCD9E8D57)
_WEYL_0 = np.uint64(0x9E3779B9)
_WEYL_1 = np.uint64(0xBB67AE85)
_MASK = np.uint64(0xFFFFFFFF)
_32 = np.uint64(32)
# Key of the hash that makes episode keys: digits of pi, as good as any.
_KEY_0 = np.uint64(0x243F6A88)
_KEY_1 = np.uint64(0x85A308D3)

# Start of the tail, and the common area of the layers (tail included).
_TAIL = 3.6541528853610088
_AREA = 0.00492867323397465494
_LAYERS = 256
_SCALE = 1 << 24


def _ziggurat_tables():
    """Return unit of abscissa (256,), accept limit (256,), density at edges (257,)."""
    # Plain Python: importing this module must not start the compiler.
    plain_exp = getattr(exp, "py_func", exp)
    density = [plain_exp(-0.5 * _TAIL * _TAIL)]
    # Layer 0 is the base strip, as wide as a rectangle of the same area.
    edge = [_AREA / density[0], _TAIL]
    while len(edge) < _LAYERS:
        density.append(density[-1] + _AREA / edge[-1])
        x = edge[-1]
        for _ in range(8):  # Newton: exp(-x*x/2) = density, as log calls another kernel
            f = plain_exp(-0.5 * x * x)
            x += (f - density[-1]) / (x * f)
        edge.append(x)
    density.append(1.0)
    edge.append(0.0)
    inner = [int(edge[i + 1] / edge[i] * _SCALE) for i in range(_LAYERS)]
    return (
        np.array([float(x) / _SCALE for x in edge[:_LAYERS]]),
        np.array(inner, dtype=np.int64),
        np.array([0.0] + [float(f) for f in density], dtype=np.float64),
    )


_UNIT, _INNER, _DENSITY = _ziggurat_tables()


@kernel(forceinline=True)
def _round(c0, c1, c2, c3, k0, k1):
    """One round of Philox4x32."""
    p0 = _MULTIPLIER_0 * c0
    p1 = _MULTIPLIER_1 * c2
    return (p1 >> _32) ^ c1 ^ k0, p1 & _MASK, (p0 >> _32) ^ c3 ^ k1, p0 & _MASK


@kernel(forceinline=True)
def philox4x32(c0, c1, c2, c3, k0, k1):
    """Philox4x32-10 block function (Salmon et al. 2011).

    Parameters
    ----------
    c0, c1, c2, c3 : uint64
        Counter words, each below 2**32.
    k0, k1 : uint64
        Key words, each below 2**32.

    Returns
    -------
    tuple of four uint64
        Output words, each below 2**32.
    """
    # 64-bit words hold the 32-bit values: the products need the width anyway.
    # Written out, because LLVM does not vectorise a loop around a loop.
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    c0, c1, c2, c3 = _round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _WEYL_0) & _MASK
    k1 = (k1 + _WEYL_1) & _MASK
    return _round(c0, c1, c2, c3, k0, k1)


@kernel(forceinline=True)
def _block(key, stream, block, attempt):
    """Four words of one counter (see the module's text)."""
    key = np.uint64(key)
    return philox4x32(
        np.uint64(block) & _MASK,
        np.uint64(stream) & _MASK,
        np.uint64(attempt),
        np.uint64(0),
        key & _MASK,
        key >> _32,
    )


@kernel
def _word(key, stream, index):
    """First word of value ``index`` of a stream."""
    w0, w1, w2, w3 = _block(key, stream, index >> 2, 0)
    lane = index & 3
    return (w0 if lane == 0 else w1) if lane < 2 else (w2 if lane == 2 else w3)


@kernel(forceinline=True)
def _unit_uniform(word):
    """Map 0 .. 2**32 - 1 into the open interval (0, 1)."""
    return (np.float64(word) + 0.5) * 2.0**-32


@kernel(forceinline=True)
def _layer_and_abscissa(word):
    """Layer, and an odd integer in (-2**24, 2**24): symmetric, and never zero."""
    return word & 255, ((word >> 7) | 1) - _SCALE


@kernel(forceinline=True)
def _normal_from(key, stream, index, word):
    """Ziggurat for value ``index`` of a stream, starting from its first word."""
    attempt = 0
    w = np.int64(word)
    while True:
        layer, m = _layer_and_abscissa(w)
        x = m * _UNIT[layer]
        if abs(m) < _INNER[layer]:
            return x
        attempt += 1
        w0, w1, w2, _ = _block(key, stream, index >> 2, 4 * attempt + (index & 3))
        if layer == 0:
            break
        low = _DENSITY[layer]
        if low + _unit_uniform(w0) * (_DENSITY[layer + 1] - low) < exp(-0.5 * x * x):
            return x
        w = np.int64(w2)
    # Tail beyond r (Marsaglia 1964).
    while True:
        beyond = -log(_unit_uniform(w0)) / _TAIL
        if -2.0 * log(_unit_uniform(w1)) >= beyond * beyond:
            return _TAIL + beyond if m > 0 else -_TAIL - beyond
        attempt += 1
        w0, w1, w2, _ = _block(key, stream, index >> 2, 4 * attempt + (index & 3))


@kernel
def _normal(key, stream, index):
    """`normal` for arguments of one type each: Numba compiles a kernel anew for every constant it is called with."""
    return _normal_from(key, stream, index, np.int64(_word(key, stream, index)))


@kernel(inline="always")
def normal(key, stream, index):
    """Standard normal number ``index`` of a stream.

    Parameters
    ----------
    key : uint64
        Episode key.
    stream : int
        Stream number, >= 0.
    index : int
        Number of the value (tick or decision), >= 0.

    Returns
    -------
    float
        Normal deviate, mean 0, variance 1.
    """
    return _normal(np.uint64(key), np.int64(stream), np.int64(index))


@kernel(inline="always")
def uniform(key, stream, index):
    """Uniform number ``index`` of a stream.

    Parameters
    ----------
    key : uint64
        Episode key.
    stream : int
        Stream number, >= 0.
    index : int
        Number of the value (tick or decision), >= 0.

    Returns
    -------
    float
        ``(word + 1/2) / 2**32``: in the open interval (0, 1).
    """
    return _unit_uniform(_word(np.uint64(key), np.int64(stream), np.int64(index)))


@kernel(forceinline=True)
def fill_normals(key, streams, block, out):
    """Four consecutive normals of many streams.

    Bit for bit, ``out[4 * s + j] = normal(key, streams[s], 4 * block + j)``.

    Parameters
    ----------
    key : uint64
        Episode key.
    streams : ndarray of int64, shape (n_streams,)
        Stream numbers, >= 0.
    block : int
        Number of the block of four values.
    out : ndarray of float64, shape (4 * n_streams,), contiguous
        Overwritten.
    """
    # The words wait, as bits, in the memory of the results: no second array.  Unsigned indices need no test for
    # negative ones, so LLVM vectorises this loop.
    for n in range(len(streams)):
        s = np.uint64(n)
        w0, w1, w2, w3 = _block(key, streams[s], block, 0)
        i = np.uint64(4) * s
        out[i] = np.uint64(w0).view(np.float64)
        out[i + np.uint64(1)] = np.uint64(w1).view(np.float64)
        out[i + np.uint64(2)] = np.uint64(w2).view(np.float64)
        out[i + np.uint64(3)] = np.uint64(w3).view(np.float64)
    for i in range(out.size):
        word = np.float64(out[i]).view(np.int64)
        layer, m = _layer_and_abscissa(word)
        x = m * _UNIT[layer]
        if abs(m) >= _INNER[layer]:
            x = _normal_from(key, streams[i >> 2], 4 * np.int64(block) + (i & 3), word)
        out[i] = x


@kernel
def episode_key(split, seed, episode):
    """Key of an episode.

    The top two bits are the split, so keys of different splits never meet; the
    other 62 are Philox4x32-10 of the counter (seed, episode) under a key that is
    fixed but for the split.

    Parameters
    ----------
    split : int
        0 to 3.
    seed, episode : uint64

    Returns
    -------
    uint64
        The key (a plain ``int`` when called from interpreted code).
    """
    split = np.uint64(split) & np.uint64(3)
    seed = np.uint64(seed)
    episode = np.uint64(episode)
    w0, w1, _, _ = philox4x32(
        seed & _MASK,
        seed >> _32,
        episode & _MASK,
        episode >> _32,
        _KEY_0,
        _KEY_1 ^ split,
    )
    low = ((w1 << _32) | w0) & np.uint64(0x3FFFFFFFFFFFFFFF)
    return (split << np.uint64(62)) | low
