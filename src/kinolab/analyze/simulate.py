"""Simulation of a machine without a planner: unforced, under given inputs, or under a policy."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from kinolab.dynamics import Model
from kinolab.dynamics.analysis.consistent_states import CONSTRAINT_TOLERANCE
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.reference import reference_motion, resimulate, trajectory_under
from kinolab.trajectory import Trajectory, reference_column
from kinolab.untrusted import text_file, why

Policy: TypeAlias = Callable[[float, Array], ArrayLike | Mapping[str, float]]


def simulate(
    problem: PlanningTask, duration: float, inputs: Path | Policy | None = None
) -> Trajectory:
    """Return the accurately integrated motion from the problem's start.

    Args:
        duration: In [s]; after the end of a file of inputs its last row is held.
        inputs: A CSV file with a column t and one per input, or a function of time and state; with
            neither all inputs are 0, or the limit nearest to 0. The function is asked at every
            step and its answer, a number per input or a table of numbers by name, is held until the
            next one, limits or not. For a machine with feedback they are its references.

    Raises:
        InputError: If the duration, the file, or what the function returns is invalid, or the start
            violates a constraint.
        DivergedError: If the motion cannot be integrated to its end.
    """
    steps = covering_steps(duration, problem.step) if math.isfinite(duration) else 0
    if not 0 < steps <= 1_000_000:
        what = f"{duration:g} s is no duration for steps of {problem.step:g} s."
        raise InputError([Mistake("duration", what, "Give a positive number of seconds.")])
    broken = list(problem.start_breaches())
    if broken:
        raise InputError(broken)
    t = np.minimum(problem.step * np.arange(steps + 1), duration)
    model = problem.model
    idle = model.null_control()
    if inputs is None:
        return resimulate(problem, t, np.tile(idle, (steps, 1)))
    if callable(inputs):
        return _under_policy(problem, t, inputs)
    times, rows = read_inputs(inputs, model)
    held = np.clip(np.searchsorted(times, t[:-1] + 1e-9, side="right") - 1, 0, None)
    return resimulate(problem, t, rows[held])


def drifting_constraints(problem: PlanningTask, motion: Trajectory) -> tuple[str, ...]:
    """Return sentences about constraints that a motion leaves: its equations are then inexact."""
    plant, u = problem.model.plant, motion.u
    if not problem.machine.constraints or not len(u):
        return ()
    residual = np.abs(plant.constraint_residual(motion.x, np.vstack([u, u[-1:]])))
    latest = residual.argmax(axis=0)
    return tuple(
        f"{plant.residual_names[i]} is off by {residual[k, i]:.3g} at t = {motion.t[k]:.6g} s, "
        f"more than the {CONSTRAINT_TOLERANCE:g} that a plan may be: masses or lengths may differ "
        "by too many orders of magnitude."
        for i, k in enumerate(latest)
        if not residual[k, i] <= CONSTRAINT_TOLERANCE
    )


def _under_policy(problem: PlanningTask, t: Array, policy: Policy) -> Trajectory:
    """Return the motion at times (N+1,), each step's inputs being asked for at its beginning."""
    model = problem.model
    x, u = np.empty((len(t), model.nx)), np.empty((len(t) - 1, model.nu))
    x[0] = problem.start
    for k in range(len(u)):
        u[k] = _inputs_of(policy, float(t[k]), x[k].copy(), model)
        held, span = u[k : k + 1], t[k : k + 2]
        x[k + 1] = reference_motion(problem, x[k], span, held, between=False).x[-1]
    return trajectory_under(model, t, x, u)


def _inputs_of(policy: Policy, t: float, x: Array, model: Model) -> Array:
    """Return what a policy answers, shape (nu,)."""
    answer, names = policy(t, x), model.control_names
    if isinstance(answer, Mapping):
        if unknown := [name for name in answer if name not in names]:
            raise UnknownNameError("input", str(unknown[0]), known=names, where="policy")
        answer = [answer.get(name, 0.0) for name in names]
    try:
        u = np.atleast_1d(np.asarray(answer, dtype=float))
    except (TypeError, ValueError):
        u = np.empty(0)
    if u.shape != (model.nu,) or not np.isfinite(u).all():
        what = f"it returned {answer!r} at t = {t:g} s."
        remedy = f"Return a finite number for each of {', '.join(names)}, or a table by name."
        raise InputError([Mistake("policy", what, remedy)])
    return u


def read_inputs(path: Path, model: Model) -> tuple[Array, Array]:
    """Read times, shape (N,), and inputs, shape (N, nu), each held until the next row.

    For a machine with feedback they are its references.

    Columns may be in any order; others, such as the states of ``trajectory.csv``, are ignored, and
    so is a last row without inputs.

    Raises:
        InputError: If the file cannot be read, lacks a column, or has a value that is not a number.
    """
    try:
        lines = csv.reader(io.StringIO(text_file(path)))
        place = {name: k for k, name in enumerate(next(lines, []))}
        rows = [row for row in lines if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError([Mistake(str(path), f"it cannot be read ({why(error)}).")]) from error
    closed = model.plant is not model
    inputs = [reference_column(n) if closed else n for n in model.control_names]
    wanted = ("t", *inputs)
    missing = [name for name in wanted if not rows or name not in place]
    if missing:
        what = f"it has no column {', '.join(missing)}."
        raise InputError([Mistake(str(path), what, f"The columns are {', '.join(wanted)}.")])
    columns = [place[name] for name in wanted]
    if len(rows) > 1 and not any("".join(rows[-1][k : k + 1]) for k in columns[1:]):
        rows.pop()
    try:
        table = np.array([[float(row[k]) for k in columns] for row in rows])
    except (IndexError, ValueError) as error:
        raise InputError([Mistake(str(path), f"a value is no number ({error}).")]) from error
    if not np.isfinite(table).all() or (np.diff(table[:, 0]) <= 0).any():
        raise InputError([Mistake(str(path), "t does not increase, or a value is not finite.")])
    return table[:, 0], table[:, 1:]
