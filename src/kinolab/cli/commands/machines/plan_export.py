"""``plan export``: write equations of motion, or the motion of a run, for other tools."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.common import PATH
from kinolab.cli.terminal import escaped, say
from kinolab.errors import InputError, Mistake

OF_MACHINES = ("c",)
OF_RUNS = ("csv", "npz", "parquet", "hdf5", "joint_trajectory", "path", "rosbag")


@click.command("export")
@click.argument("what")
@click.option(
    "--format",
    "form",
    type=click.Choice((*OF_MACHINES, *OF_RUNS)),
    help="Of a machine c; of a run one of the others.",
)
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the files; by default this one.")
def command(what: str, form: str | None, out: Path | None) -> int:
    """Write the equations of motion of WHAT, or the motion of a run, for other tools.

    WHAT is a system, a scenario, a robot's file or machine.py:function: its equations of motion
    become C source with a test, which needs a C99 compiler and no library. Or WHAT is the folder of
    a run: its motion becomes a table with units (csv, npz, parquet, hdf5), a message of ROS 2 in
    YAML (joint_trajectory, path), or a bag of ROS 2 (rosbag).
    """
    folder = out or Path()
    if Path(what).is_dir():
        return _export_run(Path(what), folder, form)
    if form not in (None, *OF_MACHINES):
        remedy = "Give the folder of a run, such as runs/rolling_disk_maze."
        raise InputError([Mistake("format", f"{form} is a format of motions.", remedy)])
    return _export_machine(what, folder)


def _export_machine(what: str, folder: Path) -> int:
    from kinolab.files import utf_8, write_whole
    from kinolab.loading import find_machine

    files = find_machine(what).to_c()
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        write_whole(folder / name, utf_8(text))
        say(escaped(f"  written to {folder / name}"))
    source, test = (name for name in files if name.endswith(".c"))
    say(f"cc -O2 -ffp-contract=off {source} {test} -lm -o test && ./test")
    return 0


def _export_run(run_folder: Path, folder: Path, form: str | None) -> int:
    from kinolab.interchange import export_motion
    from kinolab.interchange.motion_export import EXPORTS
    from kinolab.runs import read_run

    if form not in OF_RUNS:
        remedy = f"Give --format {', '.join(OF_RUNS[:-1])} or {OF_RUNS[-1]}."
        what = (
            "nothing says in which one the motion is to be written."
            if form is None
            else f"{form} is one of machines."
        )
        raise InputError([Mistake("format", what, remedy)])
    run = read_run(run_folder)
    path = export_motion(folder / EXPORTS[form].file, run.problem, run.trajectory, form)
    say(escaped(f"  written to {path}"))
    return 0
