"""``plan gallery``: many runs on one page."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress, escaped

EXIT_CODE = 7
PATH: click.Path = click.Path(path_type=Path)


@click.command("gallery")
@click.argument("folders", nargs=-1, required=True, type=PATH)
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("gallery.html"), show_default=True
)
@click.option("--title", default="Gallery", show_default=True)
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
def write_gallery(folders: tuple[Path, ...], out: Path, title: str, quiet: bool) -> int:
    """Put finished runs on one page that stands alone, each with its interactive page behind it.

    Every run is checked from its files, as by `plan check`, and the page says how that ended; the
    exit code is 7 if one fails or cannot be read.
    """
    from kinolab.files import utf_8, write_whole
    from kinolab.show.view import gallery_of

    INTERRUPTS.libraries_loaded()
    progress = Progress(quiet)
    page, cards = gallery_of(folders, title, lambda folder: progress(f"checking {folder}"))
    progress.close()
    with INTERRUPTS.writing():
        write_whole(out, utf_8(page))
    for card in cards:
        if card.verdict != "passed":
            click.echo(escaped(f"{card.name}: {card.verdict}"), err=True)
    click.echo(str(out))
    return 0 if all(card.verdict == "passed" for card in cards) else EXIT_CODE
