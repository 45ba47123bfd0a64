"""What the studio tries a plan for, in the background: machines that are not as was assumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinolab.analyze.execute.conditions import Conditions
from kinolab.concurrency.stages import heard_by
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.studio.core.background_work import Told
from kinolab.trajectory import Trajectory
from kinolab.verification.tube.uncertainty import kept_by_default

Tell = Callable[[Any], None]


@dataclass(frozen=True, eq=False)
class Executed:
    """What came of executing a plan many times.

    Attributes:
        lines: What ``plan execute`` says of it.
        paths: Of the leading body, as segments (steps, 2, 3) in [m], by how the runs ended.
        failed: The first runs that failed: their names, and their states (steps + 1, nx).
    """

    lines: tuple[str, ...]
    paths: Mapping[str, Array]
    failed: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Proved:
    """What is proved of all machines within some bounds.

    Attributes:
        lines: What ``plan prove`` says of it.
        low: Corners of boxes that contain the leading body's origin, shape (boxes, 3), in [m].
        high: Their opposite corners, of the same shape.
    """

    lines: tuple[str, ...]
    low: Array
    high: Array


def execute_plan(
    tell: Tell,
    problem: PlanningTask,
    plan: Trajectory,
    conditions: Conditions,
    runs: int,
    seed: int,
) -> Executed:
    """Execute a plan many times in closed loop, as ``plan execute`` does.

    Args:
        tell: Sends how many are done.
        problem: Which the plan solves.
        plan: The motion.
        conditions: By how much machines and sensors differ from what was assumed.
        runs: How many.
    """
    from kinolab.analyze.execute.execution import Executor
    from kinolab.analyze.execute.execution_diagnosis import diagnose_execution
    from kinolab.analyze.execute.execution_report import summary_lines

    tell(Told("designing the feedback along the plan"))
    executor = Executor(problem, plan, conditions, seed=seed)
    found = executor.tally(
        map(executor.run, range(runs)), lambda done: tell(Told(f"{done} of {runs} runs done"))
    )
    why = None
    if found.failures:
        why = diagnose_execution(executor, found, say=lambda words: tell(Told(words)))
    paths: dict[str, list[Array]] = {}
    failed: dict[str, Array] = {}
    for k, run in enumerate(found.runs):
        paths.setdefault(run.outcome, []).append(path_of(problem, run.x))
        # runs that failed whose motions are kept, to be looked at
        if run.failure is not None and len(failed) < 20:
            failed[f"run {k + 1}: {run.failure.phrase}"] = run.x
    lines = tuple(line.strip() for line in summary_lines(problem, found, why))
    return Executed(lines, {how: np.concatenate(each) for how, each in paths.items()}, failed)


def prove_plan(tell: Tell, problem: PlanningTask, plan: Trajectory, percent: float) -> Proved:
    """Prove that every machine carries a plan out, or how far it is so, as ``plan prove`` does.

    Args:
        tell: Sends what is being done.
        problem: Which the plan solves.
        plan: The motion.
        percent: By how much of its value each parameter may be off.
    """
    from kinolab.verification.tube.claim import claimed
    from kinolab.verification.tube.proof import Prover
    from kinolab.verification.tube.tube_poses import TubePoses
    from kinolab.verification.tube.uncertainty import Uncertainty, varied_by_default

    tell(Told("enclosing the motion"))
    varied = varied_by_default(problem, kept_by_default(problem.system))
    asked = Uncertainty(dict.fromkeys(varied, percent / 100.0), 0.0, 0.0)
    asked.require(problem)
    prover = Prover(problem, plan)
    with heard_by(lambda words: tell(Told(words))):
        claim = claimed(prover, asked)
    tube = claim.proof.tube
    lines = tuple(line.strip() for line in claim.lines())
    if not tube.steps:
        return Proved(lines, np.zeros((0, 3)), np.zeros((0, 3)))
    radii = claim.proof.uncertainty.radii(problem)
    frames = TubePoses.of(problem, prover.about, tube, radii).frames
    low, high = (end[problem.leading, 3::4].reshape(3, -1).T for end in (frames.low, frames.high))
    return Proved(lines, low, high)


def path_of(problem: PlanningTask, x: Array) -> Array:
    """Return the leading body's path along states (steps + 1, nx) as segments, (steps, 2, 3)."""
    places = problem.model.frames(x)[:, problem.leading, 3::4]
    return np.stack([places[:-1], places[1:]], axis=1)
