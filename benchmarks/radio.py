"""The radio of a tick, Numba's kernels against a C loop of the same arithmetic: python benchmarks/radio.py"""

import ctypes
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from rss_gym.jit import kernel
from rss_gym.params import Params
from rss_gym.physics import random
from rss_gym.physics.noise import gauss_markov
from rss_gym.physics.path_loss import received_dbm
from rss_gym.physics.random import fill_normals
from rss_gym.ranging import coloured
from rss_gym.state import channels

predict, update = coloured.predict, coloured.update

ROWS, LINKS, BLOCKS, ROUNDS = 1024, 5, 50, 7
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC")


@kernel(cache=False)
def radio(blocks, keys, streams, square, state, normals, channel):
    """`blocks` blocks of four ticks of every link of every row, with the world's own kernels."""
    gamma, offset, white_std, white_variance, a, drive, noise, floor_m = channel
    rows, links = square.shape
    for block in range(blocks):
        for row in range(rows):
            fill_normals(keys[row], streams, block, normals)
            for tick in range(4):
                for link in range(links):
                    c = state[row, link]
                    c[0] = gauss_markov(c[0], a, drive, normals[8 * link + tick])
                    rss = received_dbm(offset, gamma, square[row, link])
                    rss += c[0] + white_std * normals[8 * link + 4 + tick]
                    d, phi, p_dd, p_dp, p_pp = predict(c[1], c[2], c[3], c[4], c[5], 0.0, noise, a, drive)
                    c[1], c[2], c[3], c[4], c[5] = update(
                        d, phi, p_dd, p_dp, p_pp, rss, offset, gamma, white_variance, floor_m
                    )


def compiled(folder: str):
    """The C loop as a function, or None without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return None
    library = Path(folder) / "radio.so"
    subprocess.run([compiler, *FLAGS, str(Path(__file__).with_name("radio.c")), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library)).radio


def scene():
    """Keys, squared distances, filters and the channel of the default world."""
    generator = np.random.default_rng(0)
    params = Params()
    record = channels(params)[0]
    names = ("path_loss_factor", "offset_dbm", "white_std_db", "white_variance_db2", "coloured_decay")
    values = [record[name] for name in (*names, "coloured_drive_db")]
    channel = np.array([*values, params.ranging.process_noise_m2, params.ranging.range_floor_m])
    keys = generator.integers(2**63, size=ROWS, dtype=np.uint64)
    square = generator.uniform(5.0, 180.0, (ROWS, LINKS)) ** 2
    state = np.zeros((ROWS, LINKS, 6))
    state[..., 1], state[..., 3], state[..., 5] = 100.0, 400.0, 4.0
    return keys, square, state, np.zeros(8 * LINKS), channel


def best_ns(function, state: np.ndarray) -> float:
    """CPU nanoseconds a link and tick, the best of several rounds from the same start."""
    start, best = state.copy(), np.inf
    for _ in range(ROUNDS):
        state[:] = start
        begin = time.process_time()
        function()
        best = min(best, time.process_time() - begin)
    return best / (ROWS * LINKS * BLOCKS * 4) * 1e9


def main() -> None:
    """Print both times, their ratio, and whether the results are equal bit for bit."""
    keys, square, state, normals, channel = scene()
    start = state.copy()
    streams = np.arange(2 * LINKS)
    radio(1, keys, streams, square, state, normals, tuple(channel))
    state[:] = start
    ours = best_ns(lambda: radio(BLOCKS, keys, streams, square, state, normals, tuple(channel)), state)
    mine = state.copy()
    print(f"radio of a link and tick, {ROWS} rows x {LINKS} links, Numba: {ours:.1f} ns CPU (best of {ROUNDS})")
    with tempfile.TemporaryDirectory() as folder:
        function = compiled(folder)
        if function is None:
            print("C loop skipped: there is no C compiler on this machine")
            return
        tables = [random._UNIT, random._INNER, random._DENSITY]
        arrays = [keys, square, state, normals, channel, *tables]
        pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]
        sizes = [ctypes.c_int64(n) for n in (ROWS, LINKS, BLOCKS)]
        state[:] = start
        theirs = best_ns(lambda: function(*sizes, *pointers), state)
        same = "equal" if np.array_equal(state, mine) else "DIFFERENT"
    print(f"the same in C ({' '.join(FLAGS[:3])}): {theirs:.1f} ns; results bit for bit {same}")
    print(f"ratio Numba / C: {ours / theirs:.2f} (aim: at most 1.5)")


if __name__ == "__main__":
    main()
