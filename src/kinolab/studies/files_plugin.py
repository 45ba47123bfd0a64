"""What each worker of a Dask cluster has: the files of all problems, and processes for orders."""

from __future__ import annotations

import signal
import threading
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from distributed import Worker, WorkerPlugin, get_worker

from kinolab.studies.engine import WorkerProcesses
from kinolab.studies.orders import Answer, WorkOrder
from kinolab.studies.problem_files import ProblemFiles


@dataclass(frozen=True)
class FilesPlugin(WorkerPlugin):  # type: ignore[misc]
    """Writes files by content below the folder of a worker as it joins.

    Attributes:
        files: What orders need.
        ours: Whether this process has started the worker, and ends it: then Ctrl-C, which a
            terminal sends to both, is not for the worker.
    """

    files: tuple[ProblemFiles, ...]
    ours: bool = False

    @property
    def name(self) -> str:
        """A name that says the content: registering the same twice is once."""
        return "kinolab-" + "-".join(sorted(one.key[:8] for one in self.files))[:200]

    def setup(self, worker: Worker) -> None:
        """Write the files."""
        if self.ours and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        for one in self.files:
            one.written(files_root(worker))

    def teardown(self, worker: Worker) -> None:
        """End the processes that have done its orders."""
        crew_of(str(files_root(worker))).close()


def do_order(order: WorkOrder) -> Answer:
    """Do an order on a worker.

    Raises:
        WorkerLostError: If the process that does it was lost.
    """
    return crew_of(str(files_root(get_worker()))).answer(order)


def files_root(worker: Worker) -> Path:
    """Return the folder below which a worker keeps files."""
    return Path(worker.local_directory) / "kinolab-files"  # below a worker's own


@cache
def crew_of(root: str) -> WorkerProcesses:
    """Return the processes that do orders on this worker, from files below a folder."""
    return WorkerProcesses(Path(root))
