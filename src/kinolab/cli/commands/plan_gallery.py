"""``plan gallery``: show many runs on one page."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.common import FAILED, PATH, quiet_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import escaped, say


@click.command("gallery")
@click.argument("folders", nargs=-1, required=True, type=PATH)
@click.option("--out", type=PATH, default=Path("gallery.html"), show_default=True)
@click.option("--title", default="Gallery", show_default=True)
@quiet_option
def command(folders: tuple[Path, ...], out: Path, title: str, quiet: bool) -> int:
    """Put finished runs on one page that stands alone, each with its interactive page behind it.

    Every run is checked from its files, as by `plan check`, and the page says how that ended; the
    exit code is 7 if one fails or cannot be read.
    """
    from kinolab.files import utf_8, write_whole
    from kinolab.show.view import gallery_of

    progress = Progress(quiet)
    page, cards = gallery_of(folders, title, lambda folder: progress(f"checking {folder}"))
    progress.close()
    with INTERRUPTS.writing():
        write_whole(out, utf_8(page))
    for card in cards:
        if card.verdict != "passed":
            say(escaped(f"{card.name}: {card.verdict}"), err=True)
    say(escaped(str(out)))
    return 0 if all(card.verdict == "passed" for card in cards) else FAILED
