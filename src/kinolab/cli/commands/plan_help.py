"""``plan help``: print the manual of machines, scenarios, files and studies."""

from __future__ import annotations

import click

from kinolab.cli.terminal import say

TOPICS = {
    "machine": "the words that a machine is described with",
    "scenario": "the keys of a scenario file",
    "files": "the files of a run, and every number in them",
    "study": "the keys of a study, and the columns of its results",
}


@click.command("help")
@click.argument("topic", type=click.Choice(tuple(TOPICS)), required=False)
@click.argument("names", nargs=-1)
def command(topic: str | None, names: tuple[str, ...]) -> int:
    """Explain the words of a machine, the keys of a scenario, the files of a run, or studies.

    `plan help machine` prints the whole page, `plan help machine Spring` what is said about one
    word, `plan help scenario goal` about one section or key, `plan help` alone the topics.
    """
    if topic is None:
        for name, what in TOPICS.items():
            say(f"plan help {name:10}{what}")
        say("plan --help          the commands and options")
        return 0
    from kinolab.cli.manual import about

    click.echo_via_pager(about(topic, names))
    return 0
