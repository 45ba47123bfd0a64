"""Opening the studio: which file, in which folder, and its server."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kinolab import systems
from kinolab.errors import InputError, Mistake
from kinolab.scenario import builtin_scenarios
from kinolab.studio.core.chosen_folder import ChosenFolder
from kinolab.studio.core.edits import empty
from kinolab.studio.guarded_server import guarded_server
from kinolab.studio.scene.session import Session
from kinolab.studio.studio_page import StudioPage

MACHINE, NAME = "diff_drive", "world"  # of an empty world


@contextmanager
def opened(scenario: str | None, folder: Path | None = None) -> Iterator[str]:
    """Serve the studio while this is entered; yield the address of its page.

    Args:
        scenario: A file, a built-in scenario, or a machine's name; None for an empty world.
        folder: In which it works; the scenario's when left out.

    Raises:
        InputError: If there is no such scenario, or it cannot be read.
    """
    chosen, path, new = _places(scenario, folder)
    pages: dict[str, bytes] = {}
    server, address = guarded_server("kinolab studio", pages)
    try:
        session = Session(server, chosen, path, new, pages)
        page = StudioPage(session)
        try:
            yield address
        finally:
            page.close()
    finally:
        server.stop()


def _places(scenario: str | None, folder: Path | None) -> tuple[ChosenFolder, Path, str]:
    """Return the folder, the file, and the text of a file that is not there yet."""
    if scenario is None or scenario in systems.names():
        chosen, machine = ChosenFolder((folder or Path()).resolve()), scenario or MACHINE
        path = _free(chosen, scenario or NAME)
        return chosen, path, empty(path.stem.replace("_", " "), machine)
    if scenario in builtin_scenarios():
        chosen = ChosenFolder((folder or Path()).resolve())
        return chosen, chosen.copy_builtin(scenario), ""
    given = Path(scenario)
    if given.suffix != ".toml":
        what = "this is neither a scenario nor a machine."
        remedy = "Give a .toml file, or a name that `plan list` prints."
        raise InputError([Mistake(scenario, what, remedy)])
    chosen = ChosenFolder((folder or given.parent).resolve())
    path = chosen.path(given.resolve().as_posix())
    title = given.stem.replace("_", " ")
    return chosen, path, "" if path.exists() else empty(title, MACHINE)


def _free(folder: ChosenFolder, name: str) -> Path:
    """Return the path of a file that is not there; one that was never saved is taken up again."""
    count, path = 1, folder.path(f"{name}.toml")
    while path.exists():
        count += 1
        path = folder.path(f"{name}_{count}.toml")
    return path
