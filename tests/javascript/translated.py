"""Python functions run in JavaScript, for tests."""

import json

import pytest

from rss_gym.fly.engines import engines, result_of
from rss_gym.javascript import Program, kind_of, literal

# What a call returns, as text: doubles by their bits, which also tell zeros and NaNs apart.
SHOWN = """
const $shown = (x) => typeof x === "bigint" ? String(x) : typeof x === "boolean" ? String(x)
  : Array.isArray(x) ? x.map($shown) : Number.isNaN(x) ? "nan" : "bits " + BigInt.asUintN(64, $bits(x));
"""


def engine():
    """An engine, or the test is skipped."""
    found = engines()
    if not found:
        pytest.skip("neither node nor chromium is on the path, so no JavaScript can run")
    return next(iter(found))


def run(function, *calls, after=""):
    """What a function returns in JavaScript for each tuple of arguments; `after` is code that runs after each call."""
    program = Program()
    name = program.add(function, [kind_of(argument) for argument in calls[0]])
    code = f"{program.code}{SHOWN}const $results = [];\n"
    for call in calls:
        code += f"{{ const $args = [{', '.join(map(literal, call))}]; const $r = $shown({name}(...$args)); {after}\n"
        code += "$results.push($r); }\n"
    return json.loads(result_of(code + "const result = JSON.stringify($results);", engine()))


def shown(value):
    """A value as `run` shows it."""
    import math
    import struct

    import numpy as np

    if isinstance(value, (tuple, list)):
        return [shown(item) for item in value]
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, np.uint64):
        return str(int(value))
    if math.isnan(value):
        return "nan"
    return f"bits {struct.unpack('<Q', struct.pack('<d', float(value)))[0]}"
