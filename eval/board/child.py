"""The child process of `limits`: reads one job, limits itself, flies, and writes the table's bytes."""

from __future__ import annotations

import json
import math
import sys


def main() -> int:
    """Fly the job on the standard input; a sentence on the error stream says why not."""
    order = json.load(sys.stdin)
    _limit(order["limits"]["memory_bytes"], math.ceil(order["seconds"]))
    from rss_gym.eval.board.limits import Job, fly_here

    given = order["job"]
    changes = tuple((name, value) for name, value in given.pop("changes"))
    try:
        table = fly_here(Job(**given | {"changes": changes, "numbers": tuple(given["numbers"])}))
    except (Exception, SystemExit) as error:
        print(" ".join(f"{type(error).__name__}: {error}".split())[:1000], file=sys.stderr)
        return 1
    with open(sys.argv[1], "wb") as file:
        file.write(table.tobytes())
    return 0


def _limit(memory_bytes: int, seconds: int) -> None:
    """Bound memory, processor time and files; where the system has no such limits, the parent's clock remains."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for kind, value in (
        (resource.RLIMIT_AS, memory_bytes),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_FSIZE, 2**31),
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))


if __name__ == "__main__":
    sys.exit(main())
