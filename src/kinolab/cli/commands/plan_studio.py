"""``plan studio``: build a world in the browser, and watch it being planned for."""

from __future__ import annotations

import threading
import webbrowser
from contextlib import suppress
from pathlib import Path

import click

from kinolab.cli.common import NAMED, PATH
from kinolab.cli.terminal import escaped, say


@click.command("studio")
@click.argument("scenario", type=NAMED, required=False)
@click.option(
    "--folder",
    type=PATH,
    help="The folder in which it reads and writes, and nowhere else; by default the scenario's.",
)
@click.option("--no-browser", is_flag=True, help="Only print the page's address.")
def command(scenario: str | None, folder: Path | None, no_browser: bool) -> int:
    """Build a world with the mouse, and watch it being planned for.

    SCENARIO is a file, which may not be there yet, a built-in scenario, which is copied into the
    folder, or a machine's name for an empty world; left out, a robot in an empty world. The page is
    for this computer alone, and its address has a secret part. Ctrl-C ends it; what is not saved is
    kept beside the file, and is there again next time.
    """
    from kinolab.lazy import library_of

    for module in ("viser", "tomlkit"):
        library_of("studio", module, f"the studio needs {module}")
    from kinolab.studio.opening import opened

    with opened(scenario, folder) as address:
        say(escaped(address))
        if not (no_browser or webbrowser.open(address)):
            say(f"no browser could be started; open {address}", err=True)
        with suppress(KeyboardInterrupt):
            threading.Event().wait()
    return 0
