"""Counter-based noise: published vectors, frozen values, distributions."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest
from scipy import stats

from rss_gym.physics import random
from rss_gym.physics.random import episode_key, fill_normals, normal, philox4x32, uniform

KEY = np.uint64(episode_key(2, np.uint64(20240601), np.uint64(7)))


def fill(key, first, block, out):
    """Fill `out`, shape (streams, 4), with consecutive streams from `first` on."""
    fill_normals(np.uint64(key), np.arange(first, first + len(out)), block, out.reshape(-1))


WORD = 2**32 - 1

# Random123, file kat_vectors: counter and key, output.
KNOWN_ANSWERS = [
    ((0, 0, 0, 0, 0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((WORD,) * 6, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344, 0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]
EPISODE_KEYS = [
    ((0, 0, 0), 0x32B6D554AEFFFC8E),
    ((1, 0, 0), 0x63C64EB7EAB74352),
    ((0, 1, 0), 0x33B3174A4EC7D55F),
    ((0, 0, 1), 0x3C5AB5F416DE9A98),
    ((3, 18446744073709551615, 18446744073709551615), 0xD671AA1990E3AE24),
    ((2, 20240601, 7), 0xBB5D04A278217236),
]
# Accepted at once, then from wedges (the word kept, the word redrawn), then from the tail.
NORMALS = [
    (0, 0, "-0x1.ffcf8ac4589efp+0"),
    (0, 1, "-0x1.6cd4581bcd158p-2"),
    (1, 0, "0x1.4cd4446947631p-2"),
    (5, 1000, "-0x1.23343314a3b53p+0"),
    (2147483647, 2147483648, "0x1.80b06fb8837a0p-1"),
    (41, 2, "-0x1.95001769f2bc0p-2"),
    (43, 1, "-0x1.174aa64106775p-5"),
    (32, 0, "-0x1.024cc2e8d3f8ap+0"),
    (42, 3, "-0x1.d39a027a79867p-1"),
    (224, 1, "-0x1.e89dab3aa9130p+1"),
    (3819, 2, "-0x1.e8eee9e2f1468p+1"),
    (3932, 3, "-0x1.f73effd72daacp+1"),
]
UNIFORMS = [
    (0, 0, "0x1.1a7fb87400000p-3"),
    (3, 2, "0x1.c290ca6600000p-2"),
    (1, 2147483648, "0x1.53c4b24100000p-1"),
]


def _philox(*words):
    return tuple(int(w) for w in philox4x32(*(np.uint64(w) for w in words)))


def _reference_philox(c0, c1, c2, c3, k0, k1):
    """The same generator in the notation of the paper, in unbounded integers."""
    left, right = [c1, c3], [c0, c2]
    for r in range(10):
        keys = [(k0 + r * 0x9E3779B9) % 2**32, (k1 + r * 0xBB67AE85) % 2**32]
        products = [0xD2511F53 * right[0], 0xCD9E8D57 * right[1]]
        high, low = zip(*(divmod(p, 2**32) for p in products), strict=True)
        right = [high[1] ^ left[0] ^ keys[0], high[0] ^ left[1] ^ keys[1]]
        left = [low[1], low[0]]
    return right[0], left[0], right[1], left[1]


@numba.njit
def _normals_of(key, stream, out):
    for i in range(out.size):
        out[i] = normal(key, stream, i)


@numba.njit
def _uniforms_of(key, stream, out):
    for i in range(out.size):
        out[i] = uniform(key, stream, i)


@numba.njit
def _blocks_of(key, first_stream, out):
    streams = np.arange(first_stream, first_stream + out.shape[1])
    for b in range(out.shape[0]):
        fill_normals(key, streams, b, out[b].reshape(-1))


@numba.njit
def _keys_of(split, seeds, episodes, out):
    for i in range(seeds):
        for j in range(episodes):
            out[i, j] = episode_key(split, i << 20, j)


@pytest.fixture(scope="module")
def normals():
    """Normals by (block, stream, place in the block)."""
    out = np.empty((2000, 500, 4))
    _blocks_of(KEY, 0, out)
    return out


@pytest.mark.parametrize(("words", "expected"), KNOWN_ANSWERS)
def test_philox_known_answers(words, expected):
    assert _philox(*words) == expected
    assert _reference_philox(*words) == expected


def test_philox_against_a_reference():
    words = np.random.default_rng(1).integers(0, 2**32, (500, 6), dtype=np.uint64)
    for row in words.tolist():
        assert _philox(*row) == _reference_philox(*row)


def test_place_of_a_value():
    key = int(KEY)
    for stream, index in [(0, 0), (3, 1), (70000, 6), (2**31 - 1, 2**33 + 3)]:
        counter = ((index >> 2) % 2**32, stream, 0, 0)
        word = _reference_philox(*counter, key % 2**32, key >> 32)[index & 3]
        assert uniform(KEY, stream, index) == (word + 0.5) / 2**32


@pytest.mark.parametrize(("arguments", "expected"), EPISODE_KEYS)
def test_frozen_episode_keys(arguments, expected):
    split, seed, episode = arguments
    assert episode_key(split, np.uint64(seed), np.uint64(episode)) == expected


@pytest.mark.parametrize(("stream", "index", "expected"), NORMALS)
def test_frozen_normals(stream, index, expected):
    assert float(normal(KEY, stream, index)).hex() == expected


@pytest.mark.parametrize(("stream", "index", "expected"), UNIFORMS)
def test_frozen_uniforms(stream, index, expected):
    assert float(uniform(KEY, stream, index)).hex() == expected


@pytest.mark.parametrize("streams", [0, 1, 3, 8, 21, 500])
def test_fill_equals_normal(streams):
    key = np.uint64(episode_key(1, np.uint64(streams), np.uint64(0)))
    for first, block in [(0, 0), (17, 5), (2**31 - 600, 2**30 + 1)]:
        out = np.full((streams, 4), np.nan)
        fill(key, first, block, out)
        expected = [[normal(key, first + s, 4 * block + j) for j in range(4)] for s in range(streams)]
        expected = np.array(expected, dtype=np.float64).reshape(streams, 4)
        assert np.array_equal(out.view(np.int64), expected.view(np.int64))


def test_compiled_equals_plain_python():
    code = (
        "import numpy as np; from rss_gym.physics.random import fill_normals;"
        f"out = np.empty(1200); fill_normals(np.uint64({int(KEY)}), np.arange(1000, 1300), 3, out);"
        "print(out.tobytes().hex())"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    out = np.empty((300, 4))
    fill(KEY, 1000, 3, out)
    assert result.stdout.strip() == out.tobytes().hex()


def test_tables_close():
    top = random._DENSITY[-2] + random._AREA / (random._UNIT[-1] * 2**24)
    assert top == pytest.approx(1, abs=1e-14)
    tail = np.sqrt(2 * np.pi) * stats.norm.sf(random._TAIL)
    rectangle = random._TAIL * random._DENSITY[1]
    assert tail + rectangle == pytest.approx(random._AREA, rel=1e-14)


@pytest.mark.slow
def test_normals_follow_the_normal_law(normals):
    x = normals.ravel()
    assert stats.kstest(x, "norm").pvalue > 1e-3
    for power, mean, variance in [(1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)]:
        z = ((x**power).mean() - mean) / np.sqrt(variance / x.size)
        assert abs(z) < 4, power


@pytest.mark.parametrize("threshold", [2.0, 3.0, 3.4426, random._TAIL, 4.0, 4.5])
@pytest.mark.parametrize("sign", [-1, 1])
def test_tails(normals, threshold, sign):
    expected = stats.norm.sf(threshold) * normals.size
    z = ((sign * normals > threshold).sum() - expected) / np.sqrt(expected)
    assert abs(z) < 4


def test_normals_are_equally_likely_everywhere(normals):
    counts, _ = np.histogram(stats.norm.cdf(normals.ravel()), 4096, (0, 1))
    assert stats.chisquare(counts).pvalue > 1e-3


def test_uniforms_are_uniform():
    u = np.empty(1_000_000)
    _uniforms_of(KEY, 11, u)
    assert 0 < u.min() < u.max() < 1
    assert stats.chisquare(np.histogram(u, 1000, (0, 1))[0]).pvalue > 1e-3
    pairs, _, _ = np.histogram2d(u[:-1:2], u[1::2], 32, [(0, 1), (0, 1)])
    assert stats.chisquare(pairs.ravel()).pvalue > 1e-3


def test_uniform_never_reaches_its_bounds():
    assert random._unit_uniform(np.uint64(0)) == 2.0**-33
    assert random._unit_uniform(np.uint64(WORD)) == 1 - 2.0**-33


def _largest_correlation(a):
    """Largest absolute correlation between rows, in standard errors."""
    c = np.corrcoef(a) - np.eye(len(a))
    return np.abs(c).max() * np.sqrt(a.shape[1])


def test_streams_are_independent(normals):
    series = normals.transpose(1, 0, 2).reshape(500, -1)[:200]
    assert _largest_correlation(series) < 5.5
    assert _largest_correlation(series**2) < 5.5


def test_ticks_are_independent(normals):
    series = normals.transpose(0, 2, 1).reshape(-1, 500)
    for lag in (1, 2, 3, 4, 5, 8, 100):
        product = series[lag:] * series[:-lag]
        assert abs(product.mean()) * np.sqrt(product.size) < 4, lag


def test_keys_are_independent():
    keys = [episode_key(s, np.uint64(i), np.uint64(0)) for s in range(4) for i in range(30)]
    # Keys that differ in one bit are the hardest case.
    keys += [int(KEY) ^ (1 << b) for b in range(64)]
    rows = np.empty((len(keys), 5000))
    for key, row in zip(keys, rows, strict=True):
        _normals_of(np.uint64(key), 0, row)
    assert _largest_correlation(rows) < 5.5


def test_splits_seeds_and_episodes_have_their_own_keys():
    keys = np.empty((4, 1000, 200), dtype=np.uint64)
    for split in range(4):
        _keys_of(split, 1000, 200, keys[split])
    assert np.unique(keys).size == keys.size
    for split in range(4):
        assert np.all(keys[split] >> np.uint64(62) == split)


def test_key_bits_are_even():
    keys = np.empty((1000, 200), dtype=np.uint64)
    _keys_of(0, 1000, 200, keys)
    for bit in range(62):
        ones = int(((keys >> np.uint64(bit)) & np.uint64(1)).sum())
        assert abs(ones - keys.size / 2) < 5 * np.sqrt(keys.size) / 2, bit


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_import_compiles_nothing():
    code = (
        "from rss_gym.physics import elementary as e, random as r;"
        "kernels = [f for m in (e, r) for f in vars(m).values() if hasattr(f, 'signatures')];"
        "print(len(kernels) > 10, sum(len(f.signatures) for f in kernels))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert result.stdout.split() == ["True", "0"]
