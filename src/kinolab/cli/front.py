"""The command line: dispatch of commands, and handling of their errors.

A command's file is imported when the command is called or explained, and its dependencies when it
runs, so that ``plan --help`` is fast.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
from importlib import import_module

import click
from click import shell_completion

from kinolab.cli.common import scenarios_and_files
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.streams import COMPLETE
from kinolab.cli.terminal import say
from kinolab.errors import KinolabError, shortened_quotes

COMMANDS = (
    "scenario", "studio", "check", "execute", "prove", "bench", "plot", "video", "gallery", "view",
    "list", "equations", "describe", "simulate", "examine", "export", "new", "course",
    "warm-up", "help",
)  # fmt: skip
OF_MACHINES = ("describe", "equations", "examine", "export", "simulate", "new")  # in their folder
HELP = ("-h", "--help")
USAGE, RESOURCES, INTERNAL = 2, 6, 70  # exit codes


class _Front(click.Group):
    """A group whose first argument may be a scenario instead of a command."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in (*COMMANDS, *HELP, "--version"):
            args = ["scenario", *args]
        return super().parse_args(context, args)

    def list_commands(self, _: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, _: click.Context, name: str) -> click.Command:
        folder = "commands.machines" if name in OF_MACHINES else "commands"
        module = import_module(f"kinolab.cli.{folder}.plan_{name.replace('-', '_')}")
        command: click.Command = module.command
        return command

    def shell_complete(
        self, context: click.Context, incomplete: str
    ) -> list[shell_completion.CompletionItem]:
        """Complete commands and options, and what may stand instead of a command: scenarios."""
        found = super().shell_complete(context, incomplete)
        return found if incomplete.startswith("-") else [*found, *scenarios_and_files(incomplete)]

    def format_usage(self, _: click.Context, formatter: click.HelpFormatter) -> None:
        formatter.write_usage("plan", "SCENARIO [OPTIONS]")
        formatter.write_usage("plan", "COMMAND [ARGS]...", prefix="       ")

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        scenario, *others = (self.get_command(context, name) for name in COMMANDS)
        click.Command.format_options(scenario, context, formatter)
        with formatter.section("Commands"):
            # 200 characters of a command's summary, none of which is cut
            formatter.write_dl([(str(one.name), one.get_short_help_str(200)) for one in others])
        formatter.write_text("`plan COMMAND --help` explains a command.")


@click.group(cls=_Front, context_settings={"help_option_names": HELP})
@click.version_option(package_name="kinolab", prog_name="plan")
def plan() -> None:
    """Plan, verify and animate the motion of a machine through a world.

    SCENARIO is a TOML file, the name of a built-in scenario (`plan list` names them), an
    environment of the benchmark dynobench, a YAML file, or a problem of OMPL.app, a .cfg file.

    eval "$(_PLAN_COMPLETE=bash_source plan)" lets bash complete commands and scenarios; zsh_source
    and fish_source are for other shells.
    """


def complete(order: str) -> int:
    """Do what a shell asks that completes a line: ``bash_source``, ``bash_complete`` and so on."""
    return shell_completion.shell_complete(plan, {}, "plan", COMPLETE, order)


def execute(arguments: list[str]) -> int:
    """Run a command and return its exit code; errors become sentences on stderr."""
    try:
        with plan.make_context("plan", arguments) as context:
            result = plan.invoke(context)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    except click.ClickException as error:
        told = io.StringIO()  # it has what was typed, and a pattern types names of files
        error.show(told)
        say(shortened_quotes(told.getvalue().rstrip("\n")), err=True)
        return USAGE
    except KinolabError as error:
        for line in str(error).splitlines():
            say(f"error: {line}", err=True)
        return error.exit_code
    except click.Abort:
        raise KeyboardInterrupt from None
    except MemoryError:
        print("error: out of memory", file=sys.stderr)
        return RESOURCES
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # the reader is gone
        return 0
    except OSError as error:
        say(shortened_quotes(f"error: {error}"), err=True)
        return USAGE
    except Exception:
        INTERRUPTS.raise_if_seen()  # a library's reaction to Ctrl-C
        say(traceback.format_exc(), err=True)
        print("error: this is a mistake in kinolab; please report it.", file=sys.stderr)
        return INTERNAL
