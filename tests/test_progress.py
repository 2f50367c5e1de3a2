"""Progress: never silent, never past 100 %."""

import io
import sys

import pytest

from rss_gym import progress
from rss_gym.progress import progress_bar


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


def test_a_long_work_prints_lines_where_there_is_no_terminal(clock, monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress_bar(total=100, unit="flight", mininterval=0.0) as bar:
        for _ in range(100):
            clock[0] += 1.0
            bar.update(1)
    lines = sys.stderr.getvalue().splitlines()
    assert len(lines) == 3 and all("/100" in line and "\r" not in line for line in lines)


def test_a_short_work_and_one_that_is_to_be_silent_print_nothing(clock, monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress_bar(total=3) as bar:
        bar.update(3)
    with progress_bar(False, total=100, mininterval=0.0) as bar:
        for _ in range(100):
            clock[0] += 1.0
            bar.update(1)
    assert sys.stderr.getvalue() == ""


def test_a_terminal_gets_a_bar(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with progress_bar(total=3, mininterval=0.0) as bar:
        bar.update(1)
    assert "\r" in sys.stderr.getvalue()


def test_without_an_error_stream_there_is_no_error(monkeypatch, clock):
    monkeypatch.setattr(sys, "stderr", None)
    with progress_bar(total=3, mininterval=0.0) as bar:
        clock[0] += 100.0
        bar.update(1)
