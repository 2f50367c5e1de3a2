"""A command and its terminal: output that cannot be printed ends no work, and SIGTERM ends it in order."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import sys
from collections.abc import Iterator
from typing import Any

SENTENCE_MAX = 2000  # characters of an error; a name may be as long as a file


class Terminated(KeyboardInterrupt):
    """SIGTERM, which asks a process to end as Ctrl-C does."""


class Output:
    """A stream that goes on without a reader: after the first error it is silent, and `error` tells which it was.

    Parameters
    ----------
    stream : text stream or None
        None, as where the descriptor was closed from the start, is silent too.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self.error: Exception | None = None
        if hasattr(stream, "reconfigure"):  # characters that the terminal does not know become `?`
            with contextlib.suppress(ValueError, OSError):
                stream.reconfigure(errors="replace")

    def write(self, text: str) -> int:
        """Write, if there is still somebody to read."""
        self._try("write", text)
        return len(text)

    def flush(self) -> None:
        """Hand on what was written."""
        self._try("flush")

    def isatty(self) -> bool:
        """Whether this is a terminal."""
        return self._stream is not None and self.error is None and self._stream.isatty()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _try(self, method: str, *arguments: Any) -> None:
        if self._stream is None or self.error is not None:
            return
        try:
            getattr(self._stream, method)(*arguments)
        except (OSError, ValueError) as error:  # ValueError: a closed stream
            self.error = error
            with contextlib.suppress(OSError, ValueError, AttributeError):
                # Python flushes its streams once more when it ends.
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, self._stream.fileno())
                os.close(null)


@contextlib.contextmanager
def guarded() -> Iterator[Output]:
    """Within it, the standard streams are `Output` and SIGTERM raises `Terminated`; yields the standard output."""

    def terminate(*_: Any) -> None:
        raise Terminated

    streams = sys.stdout, sys.stderr
    before: Any = None
    with contextlib.suppress(ValueError):  # not the main thread
        before = signal.signal(signal.SIGTERM, terminate)
    output = Output(sys.stdout)
    sys.stdout, sys.stderr = output, Output(sys.stderr)
    try:
        yield output
    finally:
        output.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = streams
        if before is not None:
            signal.signal(signal.SIGTERM, before)


def say(sentence: str) -> None:
    """Print one line to the error stream, shortened in the middle where it is very long."""
    text = " ".join(sentence.splitlines())
    if len(text) > SENTENCE_MAX:
        half = SENTENCE_MAX // 2
        text = f"{text[:half]} ... {text[-half:]}"
    print(f"rss-gym: {text}", file=sys.stderr, flush=True)


def of_machine(error: BaseException) -> str | None:
    """What an error of the machine, not of the program, says in one sentence; None for any other."""
    if isinstance(error, MemoryError):
        return "there is not enough memory; fewer workers or episodes at a time need less"
    if isinstance(error, OSError) and error.errno is not None:
        place = f"{str(error.filename)!r}: " if error.filename is not None else ""
        full = "; free some space and run it again" if error.errno in (errno.ENOSPC, errno.EDQUOT) else ""
        return f"{place}{error.strerror or error}{full}"
    return None
