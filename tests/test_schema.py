"""One layer for the tables of files: any field that is spoiled is named in one sentence, with what would be right."""

import datetime
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rss_gym.eval.board import breaks, entry, season
from rss_gym.eval.reading import flights
from rss_gym.eval.reading import schema as record
from rss_gym.params import ParamsError
from rss_gym.schema import checked, line, listed, one_of, optional, real, truth, version, whole

HASH = "0" * 64
SOUND = {
    "record": (
        record.RECORD,
        {
            "schema": 4, "suite": "s", "suite_hash": HASH, "split": "suite", "seed": 0, "episodes": 1,
            "first_episode": 0, "official": True, "reference": "none", "families": [], "params": {}, "versions": {},
            "policies": [{}],
        },
    ),
    "policy": (
        record.POLICY,
        {
            "name": "a", "spec": "a", "hash": HASH, "information": "oracle", "action": "velocity", "metrics": {},
            "table": "tables/00-none.npz", "table_sha256": HASH, "folder": None,
        },
    ),
    "estimate": (record.ESTIMATE, {"value": 1.0, "low": None, "high": 2, "n": 3, "unit": ""}),
    "flights": (flights.DOCUMENT, {"format": 1, "flights": [], "failed": ["x"]}),
    "season": (
        season._FIELDS,
        {"format": 1, "name": "a", "suites": [{}], "commitment": HASH, "secret": None},
    ),
    "suite": (season._SUITE, {"name": "a", "hash": HASH, "public": 1, "sealed": 1}),
    "entry": (
        entry.FIELDS,
        {
            "format": 1, "name": "a", "author": "A", "date": datetime.date(2026, 11, 27), "licence": "MIT",
            "link": "https://example.org/x", "suite": "all", "policy": "folder",
        },
    ),
    "break": (
        breaks._FIELDS,
        {
            "format": 1, "entry": "a", "suite": "smoke-v0", "author": "A", "date": datetime.date(2026, 11, 27),
            "seed": 0, "episodes": [1, 2], "family": "", "channel": "",
        },
    ),
}  # fmt: skip
# What no field of any schema holds.
NEVER = [b"x", object(), math.nan, -1.5, ["\n"], 1j, {"\n": 1}]


@pytest.mark.parametrize("name", SOUND)
def test_what_is_sound_is_read(name):
    schema, sound = SOUND[name]
    assert checked("file", "", sound, schema) is sound


@pytest.mark.parametrize("name", SOUND)
@given(data=st.data())
def test_a_spoiled_field_is_named(name, data):
    schema, sound = SOUND[name]
    field = data.draw(st.sampled_from(sorted(schema)))
    value = data.draw(st.sampled_from(NEVER))
    kind = schema[field]
    if kind.test(value):  # a table or a number that may be anything of its kind
        assert isinstance(value, (dict, list, float))
        return
    with pytest.raises(ParamsError) as caught:
        checked("the file", "part", sound | {field: value}, schema)
    sentence = str(caught.value)
    assert sentence.startswith(f"the file: part.{field} = ") and sentence.endswith(f"must be {kind.right}")
    assert "\n" not in sentence and len(sentence) < 800


@pytest.mark.parametrize("name", SOUND)
def test_a_field_that_is_missing_or_unknown_is_named(name):
    schema, sound = SOUND[name]
    for field, kind in schema.items():
        less = {key: value for key, value in sound.items() if key != field}
        with pytest.raises(ParamsError, match=f"^file: {field} is missing; it must be "):
            checked("file", "", less, schema)
        with pytest.raises(ParamsError, match=f"field '{field}x' is unknown; did you mean '{field}'"):
            checked("file", "", less | {f"{field}x": 1}, schema)
        assert kind.right


@pytest.mark.parametrize(
    ("kind", "right", "wrong"),
    [
        (whole(1, 3), [1, 3], [0, 4, 2.0, True, "2", None]),
        (real(0.0, 1.0), [0, 1.0, 0.5], [-0.1, 2, math.nan, True, "0", 10**400]),
        (truth(), [True, False], [0, 1, "yes", None]),
        (line(3), ["a", "abc"], ["", " ", "abcd", "a\n", 1]),
        (line(3, 0), ["", "abc"], ["abcd", "\x1b"]),
        (one_of(["a", "b"]), ["a"], ["c", [], {}, None]),
        (version(3, 4), [3, 4], [2, True, 3.0, "3"]),
        (listed(1, 2, "few", whole(0, 9)), [[1], [1, 2]], [[], [1, 2, 3], ["1"], {}, None]),
        (optional(whole(0, 1)), [None, 1], [2, ""]),
    ],
    ids=range(9),
)
def test_each_kind_takes_what_it_says(kind, right, wrong):
    assert all(map(kind.test, right)) and not any(map(kind.test, wrong))
