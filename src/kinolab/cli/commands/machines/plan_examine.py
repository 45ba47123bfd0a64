"""``plan examine``: say what a machine does, what is odd about it, and whether its laws hold."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout

import click

from kinolab.cli.common import FAILED, set_option, unlogged
from kinolab.cli.terminal import say


@click.command("examine")
@click.argument("what")
@set_option
def command(what: str, overrides: tuple[str, ...]) -> int:
    """Say what WHAT does, what is odd about it, and whether the laws of mechanics hold."""
    from kinolab.analyze.examine import examine
    from kinolab.dynamics import System
    from kinolab.dynamics.machine_facts import facts_of
    from kinolab.loading import file_of_machine, find_scenario, find_system
    from kinolab.problem.warnings import machine_warnings

    with redirect_stdout(sys.stderr), unlogged():
        scenario = find_scenario(what, overrides=overrides)
        system = System.of(find_system(scenario))
    for told in machine_warnings(facts_of(system)):
        say(f"warning: {told}")
    found = examine(system, scenario.integration, file=file_of_machine(scenario))
    say(str(found))
    return FAILED if found.faults else 0
