"""The files that a run needs, under a hash of their content: they travel once, and by content."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from kinolab.files import write_whole
from kinolab.problem import PlanningTask
from kinolab.runs.assets import assets_of, portable_scenario
from kinolab.scenario import write_scenario

SCENARIO = "scenario.toml"


@dataclass(frozen=True)
class ProblemFiles:
    """Files by their paths within a folder.

    Attributes:
        files: Their content.
    """

    files: Mapping[str, bytes]

    @cached_property
    def key(self) -> str:
        """A hash of all files."""
        digest = hashlib.sha256()
        for name, content in sorted(self.files.items()):
            digest.update(f"{len(name)} {name} {len(content)} ".encode())
            digest.update(content)
        return digest.hexdigest()[:32]

    @property
    def size(self) -> int:
        """Of all files, in bytes."""
        return sum(map(len, self.files.values()))

    def written(self, root: Path) -> Path:
        """Write the files into a folder of their own below ``root`` unless they are there.

        Several processes may do so at once: the folder appears once it is complete.

        Returns:
            The folder.
        """
        folder = root / self.key
        if folder.is_dir():
            return folder
        root.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=f".{self.key}.", dir=root))
        try:
            for name, content in self.files.items():
                (draft / name).parent.mkdir(parents=True, exist_ok=True)
                write_whole(draft / name, content)
            try:
                draft.rename(folder)
            except OSError:
                if not folder.is_dir():  # unless another process was first
                    raise
        finally:
            shutil.rmtree(draft, ignore_errors=True)
        return folder


def files_of(problem: PlanningTask) -> ProblemFiles:
    """Return the files from which a problem is loaded, as the folder of a run has them."""
    assets = {f"assets/{name}": content for name, content in assets_of(problem).items()}
    return ProblemFiles({SCENARIO: write_scenario(portable_scenario(problem)).encode(), **assets})


def files_in(folder: Path, names: tuple[str, ...]) -> ProblemFiles:
    """Return files and folders of a folder, by their names in it."""
    found = [folder / name for name in names if (folder / name).exists()]
    files = [path for top in found for path in ([top] if top.is_file() else sorted(top.rglob("*")))]
    return ProblemFiles(
        {path.relative_to(folder).as_posix(): path.read_bytes() for path in files if path.is_file()}
    )
