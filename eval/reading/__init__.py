"""Reads a record that may come from a stranger: bounded in memory and time, every field checked, nothing executed.

`scores.json` is checked against the lists in `schema`; a table is read only after its zip directory and array headers
have been found to be those of the record's episodes, so that no size stated in a file is ever believed.
"""

from rss_gym.eval.reading.flights import read_flights
from rss_gym.eval.reading.plain import RecordError, parse
from rss_gym.eval.reading.record import SCORES_BYTES_MAX, Policy, Record, load
from rss_gym.eval.reading.result import definition, result_of
from rss_gym.eval.reading.table_file import EPISODES_MAX, read_table

__all__ = [
    "EPISODES_MAX",
    "SCORES_BYTES_MAX",
    "Policy",
    "Record",
    "RecordError",
    "definition",
    "load",
    "parse",
    "read_flights",
    "read_table",
    "result_of",
]
