"""The files that a run needs, under a hash of their content: they travel once, and by content."""

from __future__ import annotations

import hashlib
import logging
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from kinolab.errors import printable
from kinolab.files import is_file_with, only_writer, write_whole
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

    def written(self, root: Path) -> Path:
        """Write the files into a folder of their own below ``root`` unless exactly they are there.

        A folder of that name may come from elsewhere, as part of somebody's results; one that has
        anything else in it is replaced. Several processes may do so at once: the folder appears
        once it is complete.

        Returns:
            The folder.
        """
        folder = root / self.key
        root.mkdir(parents=True, exist_ok=True)
        with only_writer(root):
            if not self._are_all_of(folder):
                self._replace(folder)
        return folder

    def _are_all_of(self, folder: Path) -> bool:
        """Whether a folder has these files, no others, and no links to what may change."""
        if folder.is_symlink() or not folder.is_dir():
            return False
        found = [path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir()]
        return {path.relative_to(folder).as_posix() for path in found} == {*self.files} and all(
            not path.is_symlink() and is_file_with(path, self.files[name])
            for name, path in ((name, folder / name) for name in self.files)
        )

    def _replace(self, folder: Path) -> None:
        with tempfile.TemporaryDirectory(prefix=f".{self.key}.", dir=folder.parent) as beside:
            draft = Path(beside, "files")
            for name, content in self.files.items():
                (draft / name).parent.mkdir(parents=True, exist_ok=True)
                write_whole(draft / name, content)
            if os.path.lexists(folder):
                told = "warning: %s is of another content than its name says; it is replaced."
                logging.getLogger("kinolab").warning(told, printable(str(folder)))
                folder.rename(Path(beside, "replaced"))
            draft.rename(folder)


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
