"""``plan export``: write a machine, or the motion of a run, for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import NAMED, PATH, quiet_option
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import escaped, say
from kinolab.errors import InputError, Mistake

if TYPE_CHECKING:
    from kinolab.dynamics import System
    from kinolab.runs import Run

OF_MACHINES = ("c", "mjcf", "urdf")
OF_RUNS = ("csv", "npz", "parquet", "hdf5", "joint_trajectory", "path", "rosbag")


@click.command("export")
@click.argument("what", type=NAMED)
@click.option(
    "--format",
    "form",
    type=click.Choice((*OF_MACHINES, *OF_RUNS)),
    help="Of a machine c, which is the default, mjcf or urdf; of a run one of the others.",
)
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the files; else the current one.")
@click.option(
    "--partial", is_flag=True, help="Leave out what a model in MJCF or URDF cannot represent."
)
@click.option("--plant", is_flag=True, help="Without the feedback that the machine has.")
@quiet_option
def command(
    what: str, form: str | None, out: Path | None, partial: bool, plant: bool, quiet: bool
) -> int:
    """Write the machine WHAT, or the motion of a run, for other tools.

    WHAT is a system, a scenario, a robot's file or machine.py:function. Its equations of motion
    become C source with a test (c), which needs a C99 compiler and no library but the standard one.
    A machine that is a tree of bodies and joints becomes a model for MuJoCo (mjcf) or for ROS,
    Drake and Pinocchio (urdf).

    Or WHAT is the folder of a run: its machine is written likewise, or its motion becomes a table
    with units (csv, npz, parquet, hdf5), a message of ROS 2 in YAML (joint_trajectory, path), or a
    bag of ROS 2 (rosbag).
    """
    folder = out or Path()
    if partial and form not in ("mjcf", "urdf"):
        remedy = "It goes with --format mjcf or urdf."
        raise InputError([Mistake("--partial", "nothing else leaves anything out.", remedy)])
    if Path(what).is_dir() and form not in OF_MACHINES:
        return _export_run(Path(what), folder, form)
    if form in OF_RUNS:
        remedy = "Give the folder of a run, such as runs/rolling_disk_maze."
        told = f"{form} is a format of motions, and {what!r} is no folder."
        raise InputError([Mistake("--format", told, remedy)])
    progress = Progress(quiet)
    progress(f"reading and deriving {what}")
    try:
        return _export_machine(what, folder, form or "c", partial=partial, plant=plant)
    finally:
        progress.close()


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = f"it cannot be made a folder ({error.strerror})."
        raise InputError([Mistake(f"--out {folder}", what, "Name another one.")]) from error


def _machine_of(what: str) -> System:
    """Return the machine that a text names, or that of a run."""
    if Path(what).is_dir():
        from kinolab.dynamics import System
        from kinolab.runs import read_run

        return System.of(read_run(Path(what), planned=False).problem.system)
    from kinolab.loading import find_machine

    return find_machine(what)


def _export_machine(what: str, folder: Path, form: str, *, partial: bool, plant: bool) -> int:
    from kinolab.files import utf_8, write_whole

    system = _machine_of(what)
    if plant:
        system = system.with_feedback(None)
    if form == "c":
        files = system.to_c()
    else:
        from kinolab.robots import mjcf_text, urdf_text
        from kinolab.robots.tree.kinematic_tree import usable_name

        text = (mjcf_text if form == "mjcf" else urdf_text)(system, partial=partial)
        files = {usable_name(system.name) + {"mjcf": ".xml", "urdf": ".urdf"}[form]: text}
    _make(folder)
    for name, text in files.items():
        write_whole(folder / name, utf_8(text))
        say(escaped(f"  written to {folder / name}"))
    if form == "c":
        source, test = (name for name in files if name.endswith(".c"))
        say(f"cc -O2 -ffp-contract=off {source} {test} -lm -o test && ./test")
    elif form == "mjcf":
        say(escaped(f"python -m mujoco.viewer --mjcf={folder / next(iter(files))}"))
    return 0


def _export_run(run_folder: Path, folder: Path, form: str | None) -> int:
    from kinolab.interchange import export_motion
    from kinolab.interchange.motion_export import EXPORTS
    from kinolab.runs import read_run

    if form not in OF_RUNS:
        remedy = f"Give --format {', '.join(OF_RUNS)}; or {', '.join(OF_MACHINES)} of its machine."
        what = "nothing says in which one the motion is to be written."
        raise InputError([Mistake("--format", what, remedy)])
    _make(folder)
    run = read_run(run_folder, planned=False)
    path = export_motion(folder / EXPORTS[form].file, run.problem, run.trajectory, form)
    say(escaped(f"  written to {path}"))
    if form in ("joint_trajectory", "rosbag") and (left := _left_over(run)):
        say(escaped(left))
    return 0


def _left_over(run: Run) -> str:
    """Say which joints still move at the end, if any: a controller may refuse that."""
    from kinolab.interchange.ros_messages import end_speeds, has_joints, joint_trajectory

    if not has_joints(run.problem):
        return ""
    speeds = end_speeds(joint_trajectory(run.problem, run.trajectory))
    if not speeds:
        return ""
    shown = ", ".join(f"{name} {speed:.3g}" for name, speed in speeds.items())
    return (
        f"  The last point's velocity is not zero ({shown}): joint_trajectory_controller refuses "
        "that\n  unless allow_nonzero_velocity_at_trajectory_end is true; [goal] at_rest = true "
        "ends at rest."
    )
