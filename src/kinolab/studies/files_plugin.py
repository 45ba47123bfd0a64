"""What each worker of a Dask cluster is given once: the files of all problems."""

from __future__ import annotations

from dataclasses import dataclass

from distributed import Worker, WorkerPlugin

from kinolab.studies.dask_engine import files_root
from kinolab.studies.problem_files import ProblemFiles


@dataclass(frozen=True)
class FilesPlugin(WorkerPlugin):  # type: ignore[misc]
    """Writes files by content below the folder of a worker as it joins.

    Attributes:
        files: What orders need.
    """

    files: tuple[ProblemFiles, ...]

    @property
    def name(self) -> str:
        """A name that says the content: registering the same twice is once."""
        return "kinolab-" + "-".join(sorted(one.key[:8] for one in self.files))[:200]

    def setup(self, worker: Worker) -> None:
        """Write the files."""
        for one in self.files:
            one.written(files_root(worker))
