"""Who does the work of ``plan bench`` and ``plan execute``: processes here, or a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import JOBS
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.concurrency.cancel import CancellationToken

if TYPE_CHECKING:
    from kinolab.studies.engine import AbstractEngine, MakeEngine
    from kinolab.studies.problem_files import ProblemFiles

dask_option = click.option(
    "--dask",
    metavar="ADDRESS",
    help="Let a Dask cluster do the runs: its scheduler's address, or local:8.",
)
jobs_option = click.option(
    "--jobs",
    type=JOBS,
    metavar="N",
    help="Processes; by default as many as there are processors.",
)


@contextmanager
def engine_of(
    jobs: int | None, dask: str | None, progress: Progress
) -> Iterator[tuple[MakeEngine, CancellationToken]]:
    """Yield what makes the engine, from files and the folder they are in, and Ctrl-C as a token."""
    from kinolab.concurrency.processors import processors
    from kinolab.studies.engine import LocalEngine

    def engine(files: Iterable[ProblemFiles], root: Path) -> AbstractEngine:
        if dask is None:
            for one in files:
                one.written(root)
            return LocalEngine(jobs or processors(), root)
        from kinolab.studies.dask_engine import DaskEngine

        progress("connecting to Dask")
        return DaskEngine(dask, files)

    ended = threading.Event()
    INTERRUPTS.ask(ended.set)
    with INTERRUPTS.asking():
        yield engine, ended.is_set
