"""Both judgements of a motion: kinolab's verifier and the authors' own code."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints

from . import wheel
from .clearance import clearance
from .strict import miss

DEEP = 0.02  # [m]: an overlap that FCL is not asked about, for there it may hang


@dataclass(frozen=True)
class Judgement:
    """What both say; the fields are those of a run."""

    faults: tuple[str, ...]
    goal: float
    clearance: float | None
    official: Mapping[str, float]


def judge(
    file: Path, problem: PlanningTask, strict: PlanningTask, trajectory: Trajectory
) -> Judgement:
    """Judge a motion.

    Args:
        file: Of the environment.
        problem: As the benchmark states it.
        strict: With the smaller goal.
        trajectory: What was found.
    """
    failures = kinolab.verify(strict, trajectory).failures
    near = clearance(problem, trajectory)
    return Judgement(
        tuple(map(str, failures)),
        miss(problem, trajectory.x[-1]),
        near if math.isfinite(near) else None,
        official(file, problem, trajectory),
    )


def official(file: Path, problem: PlanningTask, trajectory: Trajectory) -> dict[str, float]:
    """Return what the authors' code measures; empty where it gives no answer or is not there.

    Whether bodies overlap deeply is found out first, without it: then that is the measure.
    """
    if wheel.folder() is None:
        return {}
    turned = (trajectory.x + np.pi) % (2 * np.pi) - np.pi
    x = np.where(problem.model.circular, turned, trajectory.x)
    robot, ends = problem.system.name, (problem.start, centre(problem))
    gaps = CollisionConstraints(problem, 0.0)
    overlap = -min(gaps.least(state[None]) for state in x)
    try:
        found = wheel.measures(robot, file, x, trajectory.u, problem.step, *ends)
        depth = overlap if overlap > DEEP else wheel.depth(robot, file, x)
    except subprocess.SubprocessError:
        return {}
    return {} if math.isnan(depth) else {**found, "collision": depth}


def centre(problem: PlanningTask) -> np.ndarray:
    """Return the state at the goal's centre, shape (nx,)."""
    x, goal = problem.start.copy(), problem.goal
    x[list(goal.indices)] = goal.targets
    for one in goal.parts:
        x[one.part.own] = one.target
    return x
