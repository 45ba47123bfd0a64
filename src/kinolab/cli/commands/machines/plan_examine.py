"""``plan examine``: check the laws of mechanics on a user's machine."""

from __future__ import annotations

import click

from kinolab.cli.common import FAILED, NAMED, quiet_option, unlogged
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say


@click.command("examine")
@click.argument("what", type=NAMED)
@quiet_option
def command(what: str, quiet: bool) -> int:
    """Check the laws of mechanics on WHAT, and its steps, and say what is odd."""
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.analyze.examine import examine, modes_alone
    from kinolab.dynamics import System
    from kinolab.dynamics.machine_facts import facts_of
    from kinolab.loading import find_scenario, find_system
    from kinolab.problem.warnings import machine_warnings

    progress = Progress(quiet)
    progress(f"reading {what}")
    with unlogged():
        scenario = find_scenario(what)
        system, holds = System.of(find_system(scenario)), True
    progress.close()
    for told in machine_warnings(facts_of(system)):
        say(f"warning: {told}")
    if system.modes:
        findings = list(modes_alone(system.model()))
        say("\n".join([system.name, *map(str, findings)]))
        holds = all(finding.holds for finding in findings)
    for title, machine in in_each_mode(system):
        progress(f"deriving and examining {title or system.name}")
        findings = list(examine(machine, scenario.integration))
        progress.close()
        say("\n".join([*([title] if title else []), *map(str, findings)]))
        holds = holds and all(finding.holds for finding in findings)
    return 0 if holds else FAILED
