"""Faults in the rows of a plan: values changed, rows dropped, doubled and swapped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

from .judge import DEFECT, Judge, Verdict, graded, worst
from .solids import Bodies

Array: TypeAlias = NDArray[np.float64]
Generator: TypeAlias = np.random.Generator

SMALLEST, LARGEST = 1e-4, 1.0  # of a scale
NEAR = 1e-4  # of a scale: where a plan ends, by two integrators
COARSER = 1e3  # tolerances of whole motions against those of single intervals


@dataclass(frozen=True)
class Case:
    """A good plan, and what its faults are judged with.

    Attributes:
        name: Of its folder, from that of all plans.
        problem: What it solves.
        motion: The plan.
        judge: Of its machine.
        bodies: The machine's bodies.
        folder: Where it is kept.
    """

    name: str
    problem: PlanningTask
    motion: Trajectory
    judge: Judge
    bodies: Bodies
    folder: Path

    @property
    def steps(self) -> int:
        """Number of intervals."""
        return len(self.motion.u)

    @cached_property
    def chained(self) -> Array:
        """States at all rows by the judge's own integration from the start, (N + 1, nx).

        A law gives the inputs, where there is one. Less sharp than intervals are judged, as ends of
        motions are asked for in hundredths of a tolerance; where that is not near the plan's end,
        since errors grow, as sharp.
        """
        states = self._followed(COARSER)
        if float(self.judge.apart(states[-1], self.motion.x[-1]).max()) < NEAR:
            return states
        return self._followed(1.0)

    def _followed(self, coarser: float) -> Array:
        motion, law = self.motion, self.judge.law
        states = [np.array(self.problem.start, dtype=float)]
        for k in range(self.steps):
            u = motion.u[k] if law is None else law(states[-1], motion.references[k])
            span = float(motion.t[k + 1] - motion.t[k])
            states.append(self.judge.after(states[-1], u, span, coarser))
        return np.array(states)


@dataclass(frozen=True)
class Fault:
    """A plan with one fault, and what the judge says of it.

    Attributes:
        problem: What it is said to solve.
        motion: The plan.
        verdict: The judge's.
        what: The fault in words, for a report.
    """

    problem: PlanningTask
    motion: Trajectory
    verdict: Verdict
    what: str


Kind: TypeAlias = Callable[[Case, Generator], Fault | None]


def size(generator: Generator) -> float:
    """Return a signed share of a scale, its logarithm uniform."""
    share = 10.0 ** generator.uniform(np.log10(SMALLEST), np.log10(LARGEST))
    return float(share * generator.choice([-1.0, 1.0]))


def _moved(case: Case, k: int, x: Array, what: str) -> Fault:
    """Return the fault that row k has another state.

    By magnitude: row k follows from the row before within a tolerance, so that what is moved by
    more does not; the first row is the start itself.
    """
    motion = replace(case.motion, x=case.motion.x.copy())
    motion.x[k] = x
    if k == 0:
        return Fault(case.problem, motion, case.judge.starts(motion), what)
    moved = float(case.judge.apart(case.motion.x[k], x).max()) / DEFECT - 1.0
    return Fault(case.problem, motion, graded(moved, "moved away from what follows"), what)


def state(case: Case, generator: Generator) -> Fault | None:
    """Change an entry of a row by a share of its scale; quaternions have a kind of their own."""
    taken = {i for own in case.judge.attitudes for i in range(own.start, own.stop)}
    i = int(generator.choice([i for i in range(len(case.judge.states)) if i not in taken]))
    k, share = int(generator.integers(case.steps + 1)), size(generator)
    x = case.motion.x[k].copy()
    x[i] += share * case.judge.scales[i]
    return _moved(case, k, x, f"row {k}: {case.judge.states[i]} by {share:.3g} of its scale")


def input_(case: Case, generator: Generator) -> Fault | None:
    """Change an input of an interval by a share of its range."""
    if not case.steps:
        return None
    k, i = int(generator.integers(case.steps)), int(generator.integers(case.motion.u.shape[1]))
    share = size(generator)
    motion = replace(case.motion, u=case.motion.u.copy())
    motion.u[k, i] += share * float(np.ptp(case.judge.limits[i]))
    judge = case.judge
    verdict = worst(
        [judge.inputs(motion, [k]), judge.feedback(motion, [k]), judge.rows(motion, [k])]
    )
    name = case.motion.control_names[i]
    return Fault(case.problem, motion, verdict, f"row {k}: {name} by {share:.3g} of its range")


def reference(case: Case, generator: Generator) -> Fault | None:
    """Change a reference of the machine's feedback by a share of its range."""
    motion = case.motion
    if not motion.reference_names or not case.steps:
        return None
    k = int(generator.integers(case.steps))
    i = int(generator.integers(len(motion.reference_names)))
    share = size(generator)
    motion = replace(motion, references=motion.references.copy())
    motion.references[k, i] += share * float(np.ptp(case.problem.model.control_bounds[i]))
    verdict = worst([case.judge.inputs(motion, [k]), case.judge.feedback(motion, [k])])
    name = motion.reference_names[i]
    return Fault(case.problem, motion, verdict, f"row {k}: {name} by {share:.3g} of its range")


def time(case: Case, generator: Generator) -> Fault | None:
    """Move a row's time by a share of its interval."""
    k, share = int(generator.integers(case.steps + 1)), size(generator)
    motion = replace(case.motion, t=case.motion.t.copy())
    span = float(motion.t[k] - motion.t[k - 1]) if k else float(motion.t[1])
    motion.t[k] += share * span
    what = f"row {k}: time by {share:.3g} of an interval"
    if k == 0:
        return Fault(case.problem, motion, Verdict("false", "it does not begin at 0"), what)
    if not (np.diff(motion.t) > 0).all():
        return Fault(case.problem, motion, Verdict("false", "times do not increase"), what)
    return Fault(case.problem, motion, case.judge.rows(motion, [k - 1, k]), what)


def later(case: Case, generator: Generator) -> Fault | None:
    """Make an interval longer or shorter by a share, and all that comes after later or sooner."""
    if not case.steps:
        return None
    k, share = int(generator.integers(case.steps)), size(generator)
    motion = replace(case.motion, t=case.motion.t.copy())
    motion.t[k + 1 :] += share * float(motion.t[k + 1] - motion.t[k])
    what = f"row {k}: its interval by {share:.3g} of it"
    if not (np.diff(motion.t) > 0).all():
        return Fault(case.problem, motion, Verdict("false", "times do not increase"), what)
    return Fault(case.problem, motion, case.judge.rows(motion, [k]), what)


def quaternion(case: Case, generator: Generator) -> Fault | None:
    """Change an entry of a quaternion, turn it, or make it longer."""
    if not case.judge.attitudes:
        return None
    own = case.judge.attitudes[int(generator.integers(len(case.judge.attitudes)))]
    k, share = int(generator.integers(case.steps + 1)), size(generator)
    x, how = case.motion.x[k].copy(), str(generator.choice(["entry", "turned", "longer"]))
    if how == "entry":
        x[own.start + int(generator.integers(4))] += share
    elif how == "turned":
        axis = generator.normal(size=3)
        turn = Rotation.from_rotvec(share * axis / np.linalg.norm(axis))
        x[own] = (Rotation.from_quat(x[own]) * turn).as_quat()
    else:
        x[own] *= 1.0 + share
    return _moved(case, k, x, f"row {k}: quaternion {how} by {share:.3g}")


def dropped(case: Case, generator: Generator) -> Fault | None:
    """Leave out a row or several, with their inputs."""
    count = int(generator.integers(1, 4))
    if case.steps < count + 2:
        return None
    k = int(generator.integers(case.steps + 1 - count + 1))
    rows = np.arange(k, k + count)
    old, what = case.motion, f"rows {k} to {k + count - 1} left out"
    held = rows if k + count <= case.steps else rows - 1
    motion = replace(
        old,
        t=np.delete(old.t, rows),
        x=np.delete(old.x, rows, axis=0),
        u=np.delete(old.u, held, axis=0),
        references=np.delete(old.references, held, axis=0),
    )
    if k == 0:
        return Fault(case.problem, motion, Verdict("false", "it does not begin at 0"), what)
    if k + count > case.steps:
        return Fault(case.problem, motion, _cut_short(case, motion), what)
    judge = case.judge
    verdict = worst([judge.feedback(motion, [k - 1]), judge.rows(motion, [k - 1])])
    return Fault(case.problem, motion, verdict, what)


def _cut_short(case: Case, motion: Trajectory) -> Verdict:
    """Judge a motion that ends too soon, by the goal; targets of bodies are not judged here."""
    if case.problem.goal.needs_frames:
        return Verdict("unknown", "the goal is about bodies")
    return case.judge.ends(motion.x[-1])


def doubled(case: Case, generator: Generator) -> Fault | None:
    """Write a row twice: at the same time, or with all that comes after one interval later."""
    if not case.steps:
        return None
    k, old = int(generator.integers(case.steps)), case.motion
    motion = replace(
        old,
        t=np.insert(old.t, k, old.t[k]),
        x=np.insert(old.x, k, old.x[k], axis=0),
        u=np.insert(old.u, k, old.u[k], axis=0),
        references=np.insert(old.references, k, old.references[k], axis=0),
    )
    if generator.random() < 0.5:
        return Fault(
            case.problem, motion, Verdict("false", "times do not increase"), f"row {k} twice"
        )
    motion.t[k + 1 :] += float(old.t[k + 1] - old.t[k])
    verdict = case.judge.rows(motion, [k])
    return Fault(case.problem, motion, verdict, f"row {k} twice, and the rest later")


def swapped(case: Case, generator: Generator) -> Fault | None:
    """Swap two rows: whole ones, their states, or their inputs."""
    if case.steps < 3:
        return None
    j, k = sorted(generator.choice(case.steps, 2, replace=False).tolist())
    how, old = str(generator.choice(["rows", "states", "inputs"])), case.motion
    order = np.arange(case.steps + 1)
    order[[j, k]] = k, j
    what, judge = f"rows {j} and {k}: {how} swapped", case.judge
    if how == "rows":
        held = order[: case.steps]
        motion = replace(
            old, t=old.t[order], x=old.x[order], u=old.u[held], references=old.references[held]
        )
        return Fault(case.problem, motion, Verdict("false", "times do not increase"), what)
    if how == "states":
        motion = replace(old, x=old.x[order])
        moved = float(judge.apart(old.x[j], old.x[k]).max()) / DEFECT - 1.0
        verdict = graded(moved, "moved away from what follows")
        return Fault(case.problem, motion, verdict, what)
    held = order[: case.steps]
    motion = replace(old, u=old.u[held], references=old.references[held])
    verdict = worst([judge.feedback(motion, [j, k]), judge.rows(motion, [j, k])])
    return Fault(case.problem, motion, verdict, what)


KINDS: dict[str, Kind] = {
    "state": state,
    "input": input_,
    "reference": reference,
    "time of a row": time,
    "interval": later,
    "quaternion": quaternion,
    "rows dropped": dropped,
    "row doubled": doubled,
    "rows swapped": swapped,
}
