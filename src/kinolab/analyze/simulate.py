"""Simulation of a machine without a planner, unforced or under given inputs."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory, reference_column

MAX_STEPS = 1_000_000


def simulate(problem: PlanningTask, duration: float, inputs: Path | None = None) -> Trajectory:
    """Return the accurately integrated motion from the problem's start.

    Args:
        problem: Provides machine, start and step.
        duration: In [s]; after the end of a file of inputs its last row is held.
        inputs: A CSV file with a column t and one per input; without it all inputs are 0, or the
            limit nearest to 0.

    Raises:
        InputError: If the duration or the file is invalid, or the start violates a constraint.
        DivergedError: If the motion cannot be integrated to its end.
    """
    steps = math.ceil(duration / problem.step - 1e-9) if math.isfinite(duration) else 0
    if not 0 < steps <= MAX_STEPS:
        what = f"{duration:g} s is no duration for steps of {problem.step:g} s."
        raise InputError([Mistake("--duration", what, "Give a positive number of seconds.")])
    broken = list(problem.start_breaches())
    if broken:
        raise InputError(broken)
    t = np.minimum(problem.step * np.arange(steps + 1), duration)
    model = problem.model
    idle = np.clip(np.zeros(model.nu), *model.control_bounds.T)
    if inputs is None:
        return resimulate(problem, t, np.tile(idle, (steps, 1)))
    times, rows = read_inputs(inputs, model)
    held = np.clip(np.searchsorted(times, t[:-1] + 1e-9, side="right") - 1, 0, None)
    return resimulate(problem, t, rows[held])


def read_inputs(path: Path, model: Model) -> tuple[Array, Array]:
    """Read times, shape (N,), and inputs, shape (N, nu), each held until the next row.

    For a machine with feedback they are its references.

    Columns may be in any order; others, such as the states of ``trajectory.csv``, are ignored, and
    so is a last row without inputs.

    Raises:
        InputError: If the file cannot be read, lacks a column, or has a value that is not a number.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError([Mistake(str(path), f"it cannot be read ({error}).")]) from error
    closed = model.plant is not model
    inputs = [reference_column(n) if closed else n for n in model.control_names]
    wanted = ("t", *inputs)
    missing = [name for name in wanted if not rows or name not in rows[0]]
    if missing:
        what = f"it has no column {', '.join(missing)}."
        raise InputError([Mistake(str(path), what, f"The columns are {', '.join(wanted)}.")])
    if len(rows) > 1 and not any(rows[-1][name] for name in inputs):
        rows.pop()
    try:
        table = np.array([[float(row[name]) for name in wanted] for row in rows])
    except (TypeError, ValueError) as error:
        raise InputError([Mistake(str(path), f"a value is no number ({error}).")]) from error
    if not np.isfinite(table).all() or (np.diff(table[:, 0]) <= 0).any():
        raise InputError([Mistake(str(path), "t does not increase, or a value is not finite.")])
    return table[:, 0], table[:, 1:]
