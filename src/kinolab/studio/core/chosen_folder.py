"""The folder in which the studio reads and writes, and nothing outside of it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from kinolab.errors import InputError, Mistake
from kinolab.files import read_ordinary, utf_8, write_whole
from kinolab.scenario import builtin_scenarios, read_text
from kinolab.scenario.values import MESH_FORMATS
from kinolab.studio.core.edits import obstacles
from kinolab.studio.core.scenario_text import ScenarioText

SIZE_LIMIT = 32_000_000  # [bytes] of a file that is sent to the studio, or kept by it
MESHES = "meshes"  # where meshes go that are sent to the studio


@dataclass(frozen=True)
class ChosenFolder:
    """A folder.

    Args:
        root: The folder; nothing outside of it is read or written.
    """

    root: Path

    def path(self, name: str) -> Path:
        """Return the path of a file in it, which may be in a folder below.

        Raises:
            InputError: If it is outside.
        """
        root = self.root.resolve()
        place = root if "\0" in name else (root / name).resolve()
        if not place.is_relative_to(root) or place == root:
            what = "this is outside of the folder in which the studio works."
            raise InputError([Mistake(name[:80], what, f"It works in {self.root}.")])
        return place

    def scenarios(self) -> list[str]:
        """Return the names of the scenarios in it, the one that was changed last first."""
        found = [path for path in self.root.glob("*.toml") if not path.name.startswith(".")]
        found.sort(key=lambda path: (-path.stat().st_mtime, path.name))
        return [path.name for path in found][:200]

    def meshes(self) -> list[str]:
        """Return the mesh files in it and in its folders, as scenarios name them."""
        found = sorted(
            path.relative_to(self.root).as_posix()
            for depth in ("*", "*/*")
            for path in self.root.glob(depth)
            if path.suffix.lower() in MESH_FORMATS and path.is_file()
        )
        return found[:200]

    def keep_mesh(self, name: str, content: bytes) -> str:
        """Keep a mesh that was sent; return its name, as scenarios write it.

        Raises:
            InputError: If it is too large, or its name is not a mesh's.
        """
        stem = PurePosixPath(name.replace("\\", "/")).name
        if PurePosixPath(stem).suffix.lower() not in MESH_FORMATS or stem.startswith("."):
            what = "this is not a mesh that kinolab reads."
            raise InputError([Mistake(name[:80], what, f"It reads {', '.join(MESH_FORMATS)}.")])
        if len(content) > SIZE_LIMIT:
            what = f"the file is larger than {SIZE_LIMIT // 1_000_000} MB."
            raise InputError([Mistake(stem, what, "Reduce the mesh.")])
        place = self.path(f"{MESHES}/{stem}")
        if place.exists() and place.read_bytes() != content:
            what = "there is another file of this name."
            raise InputError([Mistake(f"{MESHES}/{stem}", what, "Rename one of them.")])
        place.parent.mkdir(exist_ok=True)
        write_whole(place, content)
        return f"{MESHES}/{stem}"

    def copy_builtin(self, name: str) -> Path:
        """Copy a built-in scenario with its meshes, unless it is there already; return its path."""
        source, place = builtin_scenarios()[name], self.path(f"{name}.toml")
        if not place.exists():
            text = read_text(source)
            for obstacle in obstacles(ScenarioText(text).values):
                if mesh := obstacle.get("mesh"):
                    copy = self.path(mesh)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    if not copy.exists():
                        shutil.copyfile(source.parent / mesh, copy)
            write_whole(place, utf_8(text))
        return place

    def open(self, path: Path) -> tuple[ScenarioText, bool]:
        """Read a scenario, with what was not saved as its last edit; say whether there was any.

        Raises:
            InputError: If it cannot be read.
        """
        saved = _text(path) if path.exists() else ""
        opened, kept = ScenarioText(saved, saved), autosave(path)
        if not kept.is_file():
            return opened, False
        unsaved = read_ordinary(kept, SIZE_LIMIT).decode("utf-8", "replace")
        return opened, opened.write("what was not saved", unsaved)

    def autosave(self, path: Path, document: ScenarioText) -> None:
        """Keep what is not saved beside the file."""
        if document.text == document.saved:
            autosave(path).unlink(missing_ok=True)
        else:
            write_whole(autosave(path), utf_8(document.text))

    def save(self, path: Path, document: ScenarioText) -> None:
        """Write the file."""
        write_whole(path, utf_8(document.text))
        document.saved = document.text
        autosave(path).unlink(missing_ok=True)


def autosave(path: Path) -> Path:
    """Return where what is not saved of a file is kept."""
    return path.with_name(f".{path.name}.autosave")


def _text(path: Path) -> str:
    read_text(path)  # says what is wrong with a file; it leaves out a byte order mark
    return path.read_bytes().decode("utf-8")
