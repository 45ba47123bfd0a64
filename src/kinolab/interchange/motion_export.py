"""Formats in which the motion of a run is written for other tools."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from kinolab.arguments import checked
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.files import write_whole
from kinolab.interchange.motion_tables import csv_table, hdf5_table, npz_table, parquet_table
from kinolab.interchange.ros_messages import Message, joint_trajectory, path_message
from kinolab.interchange.rosbag import write_bag
from kinolab.problem import PlanningTask
from kinolab.problem.own_motion import other_machine
from kinolab.trajectory import Trajectory
from kinolab.untrusted import why

Encoder = Callable[[PlanningTask, Trajectory], bytes]


class Export(NamedTuple):
    """A format.

    Attributes:
        file: What its file is called unless told otherwise.
        content: Returns that; None where it is a folder, a bag.
    """

    file: str
    content: Encoder | None


def _yaml(message: Callable[[PlanningTask, Trajectory], Message]) -> Encoder:
    text = partial(yaml.safe_dump, sort_keys=False, default_flow_style=None, width=100)
    return lambda problem, trajectory: text(message(problem, trajectory)).encode()


EXPORTS = {
    "csv": Export("motion.csv", csv_table),
    "npz": Export("motion.npz", npz_table),
    "parquet": Export("motion.parquet", parquet_table),
    "hdf5": Export("motion.h5", hdf5_table),
    "joint_trajectory": Export("joint_trajectory.yaml", _yaml(joint_trajectory)),
    "path": Export("path.yaml", _yaml(path_message)),
    "rosbag": Export("bag", None),
}


@checked
def export_motion(
    path: str | Path, problem: PlanningTask, trajectory: Trajectory, form: str
) -> Path:
    """Write a motion in the format of another tool, whole or not at all.

    Args:
        path: Of the file, or of the folder of a bag; its own folder is made where it is missing.
        problem: The problem of the motion.
        trajectory: The motion.
        form: One of ``EXPORTS``: csv, npz, parquet, hdf5, joint_trajectory, path, rosbag.

    Returns:
        The path.

    Raises:
        InputError: If there is no such format, it does not suit the machine, or a library is
            missing.
    """
    _require_sound(problem, trajectory)
    if form not in EXPORTS:
        raise UnknownNameError("format", form, known=tuple(EXPORTS), where="export")
    path, content = Path(path), EXPORTS[form].content
    if not path.name:
        raise InputError([Mistake("export_motion path", "it names no file.", "Give a path.")])
    try:
        if content is None:
            write_bag(path, problem, trajectory)
        else:
            encoded = content(problem, trajectory)
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, encoded)
    except OSError as error:
        what = f"it cannot be written ({why(error)})."
        raise InputError([Mistake(str(path), what, "Name a file in another folder.")]) from error
    return path


def _require_sound(problem: PlanningTask, trajectory: Trajectory) -> None:
    """Require that a motion is one of a problem's machine; whether it is true is not asked."""
    mistakes = list(other_machine(problem, trajectory))
    if not (np.diff(trajectory.t) > 0.0).all():
        mistakes.append(Mistake("trajectory", "its times do not increase."))
    numbers = (trajectory.t, trajectory.x, trajectory.u, trajectory.references)
    if not all(np.isfinite(table).all() for table in numbers):
        mistakes.append(Mistake("trajectory", "it has numbers that are not finite."))
    if mistakes:
        raise InputError(mistakes)
