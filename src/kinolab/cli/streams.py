"""Standard streams that are closed, or that cannot be written, as those of services and full disks.

A closed one is dangerous: the next file that is opened takes its number, and gets what is meant for
the stream.
"""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress

COMPLETE = "_PLAN_COMPLETE"  # the variable in which a shell asks how a line may go on


class _Messages(io.TextIOWrapper):
    """A stream for messages: what cannot be written is lost, and ends nothing."""

    def write(self, text: str) -> int:
        with suppress(OSError):
            super().write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError):
            super().flush()


def prepare_streams() -> None:
    """Put the null device where a stream is closed, and lose messages that cannot be written."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):  # by their numbers
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number, which is this one
        if getattr(sys, name) is None:
            stream = open(number, "w" if number else "r", closefd=False)  # noqa: SIM115
            setattr(sys, name, stream)
    with suppress(AttributeError, OSError):  # another kind of stream
        sys.stderr.flush()
        # 2 is standard error
        buffer = open(2, "wb", closefd=False)  # noqa: SIM115
        sys.stderr = _Messages(
            buffer,
            encoding=sys.stderr.encoding,
            errors="backslashreplace",
            line_buffering=True,
        )
