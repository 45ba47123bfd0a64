"""``plan examine``: check the laws of mechanics on a user's machine."""

from __future__ import annotations

import click

from kinolab.cli.common import FAILED


@click.command("examine")
@click.argument("what")
def command(what: str) -> int:
    """Check the laws of mechanics on WHAT, and its steps, and say what is odd."""
    from kinolab.analyze.examine import examine
    from kinolab.loading import find_scenario, find_system

    scenario = find_scenario(what)
    findings = list(examine(find_system(scenario), scenario.integration))
    click.echo("\n".join(map(str, findings)))
    return 0 if all(finding.holds for finding in findings) else FAILED
