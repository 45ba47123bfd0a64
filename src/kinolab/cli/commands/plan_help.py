"""``plan help``: print the manual of machines, scenarios and files."""

from __future__ import annotations

import click

TOPICS = ("machine", "scenario", "files")


@click.command("help")
@click.argument("topic", type=click.Choice(TOPICS))
@click.argument("names", nargs=-1)
def command(topic: str, names: tuple[str, ...]) -> int:
    """Explain the words of a machine, the keys of a scenario, or the files of a run.

    `plan help machine` prints the whole page, `plan help machine Spring` what is said about one
    word, `plan help scenario goal` about one section or key.
    """
    from kinolab.cli.manual import about

    click.echo_via_pager(about(topic, names))
    return 0
