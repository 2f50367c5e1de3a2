"""Time of scoring a learned policy: python benchmarks/agents.py [--policy NAME|FOLDER] [--million].

Without a policy it is an untrained network of the usual size that flies to the right: the arithmetic of a trained
one, and flights as long. The time holds all of `evaluate`: also the flights of `none`, which every score needs, the
start of the workers, metrics and intervals. Other work on the machine counts into wall time.
"""

import argparse
import json
import resource
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np
from safetensors.numpy import save_file

from rss_gym.baselines.policy_files import DOCUMENT, FORMAT, WEIGHTS, Network
from rss_gym.eval import evaluate
from rss_gym.params import Params

SIZES = (10_000, 50_000)
MILLION, TARGET_S = 1_000_000, 12 * 60


def network(folder: Path, layers: list[int]) -> str:
    """Write a policy that moves its way point to the right, with random hidden layers."""
    params, shape = Params(), Network(layers=tuple(layers))
    generator = np.random.default_rng(0)
    tensors = {name: generator.normal(0.0, 0.1, size).astype(np.float32) for name, size in shape.shapes(params).items()}
    last = len(layers)
    tensors[f"{last}.weight"] *= 0.0
    tensors[f"{last}.bias"] = np.array([0.0, 1.0], np.float32)
    save_file(tensors, folder / WEIGHTS)
    document = {"format": FORMAT, "network": asdict(shape), "interface": params.interface.to_dict()}
    document |= {"observation": shape.inputs(params), "training": {}}
    (folder / DOCUMENT).write_text(json.dumps(document))
    return str(folder)


def seconds(policy: str, episodes: int, workers: int) -> tuple[float, float]:
    """Wall and CPU time of one score, of this process and its workers."""

    def cpu_s() -> float:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(item.ru_utime + item.ru_stime for item in used)

    start, before_s = time.perf_counter(), cpu_s()
    evaluate({"agent": policy}, episodes=episodes, workers=workers, progress=False)
    return time.perf_counter() - start, cpu_s() - before_s


def main() -> None:
    """Print the table and what it means for a million."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policy", help="name or folder, of `Encounter-v0`; default: an untrained network")
    parser.add_argument("--layers", type=int, nargs="+", default=[128, 128], help="units of the untrained network")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--million", action="store_true", help="fly 1,000,000 encounters, not 10,000 and 50,000")
    options = parser.parse_args()
    sizes = (MILLION,) if options.million else SIZES
    with tempfile.TemporaryDirectory() as folder:
        policy = options.policy or network(Path(folder), options.layers)
        evaluate({"agent": policy}, episodes=16)  # compiled code comes from the cache
        print(f"{'encounters':>10} {'wall s':>8} {'CPU s':>8}")
        found = []
        for episodes in sizes:
            found.append(seconds(policy, episodes, options.workers))
            print(f"{episodes:>10} {found[-1][0]:8.1f} {found[-1][1]:8.1f}", flush=True)
    if not options.million:
        wall_s, cpu_s = (
            last + (last - first) / (sizes[1] - sizes[0]) * (MILLION - sizes[1])
            for first, last in zip(*found, strict=True)
        )
        print(f"{MILLION:>10} {wall_s:8.0f} {cpu_s:8.0f}  (on the line through these two, not flown)")
        print(f"CPU over {options.workers} workers: {cpu_s / options.workers / 60:.1f} min if nothing else runs")
    print(f"target: {MILLION:,} encounters under {TARGET_S / 60:.0f} min on two cores")


if __name__ == "__main__":
    main()
