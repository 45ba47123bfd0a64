"""The command ``plan``; Ctrl-C is handled before anything else is imported."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress

from kinolab.cli.interrupts import EXIT_CODE, INTERRUPTS
from kinolab.cli.streams import COMPLETE, prepare_streams


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; errors become sentences on stderr."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with INTERRUPTS.watched():
            from kinolab.cli.front import execute

            return execute(given)
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return EXIT_CODE


def main() -> None:
    """Enter from the console script."""
    if order := os.environ.get(COMPLETE):
        from kinolab.cli.front import complete

        sys.exit(complete(order))
    INTERRUPTS.guard()
    prepare_streams()
    if sys.platform != "win32":
        from kinolab.cli.supervisor import supervise

        supervise()
    with suppress(AttributeError):  # None, or another kind of stream
        sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]  # for paths
    # Matrices are small: threads of BLAS wait for each other on a busy computer, some 10 ms for
    # each product, and sums would depend on the number of cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Young objects per collection. Importing makes a million that stay; by Python's own threshold,
    # going through them again and again took a tenth of a plan.
    gc.set_threshold(100_000, *gc.get_threshold()[1:])
    code = run()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # nothing is left to interrupt
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, OSError, ValueError):  # None, a reader that is gone, closed
            stream.flush()
    INTERRUPTS.leave(code)  # at once: libraries shut down slowly
