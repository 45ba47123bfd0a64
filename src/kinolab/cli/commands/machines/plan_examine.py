"""``plan examine``: say what a machine does, what is odd about it, and whether its laws hold."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout

import click

from kinolab.cli.common import FAILED, NAMED, quiet_option, set_option, unlogged
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say


@click.command("examine")
@click.argument("what", type=NAMED)
@set_option
@quiet_option
def command(what: str, overrides: tuple[str, ...], quiet: bool) -> int:
    """Say what WHAT does, what is odd about it, and whether the laws of mechanics hold."""
    from kinolab.analyze.examine import examine
    from kinolab.dynamics import System
    from kinolab.dynamics.facts.machine_facts import facts_of
    from kinolab.loading import file_of_machine, find_scenario, find_system, stated_start
    from kinolab.problem.warnings import machine_warnings

    progress = Progress(quiet)
    progress(f"reading {what}")
    with redirect_stdout(sys.stderr), unlogged():
        scenario = find_scenario(what, overrides=overrides)
        system = System.of(find_system(scenario))
    progress.close()
    for told in machine_warnings(facts_of(system)):
        say(f"warning: {told}")
    progress(f"deriving and examining {system.name}")
    file, start = file_of_machine(scenario), stated_start(scenario, system)
    found = examine(system, scenario.integration, file=file, start=start)
    progress.close()
    say(str(found))
    return FAILED if found.faults else 0
