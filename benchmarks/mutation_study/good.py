"""Good plans in all their ways of being written: none may be refused."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from kinolab.runs import read_run
from kinolab.trajectory import Trajectory

from . import nested
from .faults import NEAR, Case, Fault, Generator
from .judge import DEFECT, WALKS, Verdict, graded, worst
from .machines import ANYWHERE, EMPTY, hopped
from .worlds import like

Good: TypeAlias = Callable[[Case, Generator], Fault | None]

_SOUND: dict[str, Verdict] = {}  # of whole plans, by name

INSIDE = 0.99  # tolerances from the goal's centre
ROWS = 20  # of motions that the judge makes
STIRRED = 0.02  # of an input's range, by which it changes a plan's inputs
LOOKS = 8  # within an interval, for limits
MARGIN = 0.01  # of a scale that is kept from limits by what the judge makes


def as_found(case: Case, _generator: Generator) -> Fault | None:
    """Return the plan as it was found, all of it judged."""
    return Fault(case.problem, case.motion, sound(case), "as it was found")


def sound(case: Case) -> Verdict:
    """Return the judge's verdict on a whole plan, which is kept with it."""
    if case.name not in _SOUND:
        verdict = case.judge.whole(case.motion)
        if case.problem.goal.needs_frames:
            verdict = worst([verdict, _aims(case)])
        _SOUND[case.name] = verdict
    return _SOUND[case.name]


def _aims(case: Case) -> Verdict:
    """Judge whether axes of bodies point where they must."""
    if case.problem.goal.points:
        return Verdict("unknown", "the goal is about points of bodies")
    poses, shares = case.bodies.poses(case.motion.x[-1]), [0.0]
    for target in case.problem.goal.directions:
        axis = poses[target.body][:3, :3] @ np.array(target.axis)
        wanted = np.array(target.target)
        angle = np.arctan2(np.linalg.norm(np.cross(axis, wanted)), axis @ wanted)
        shares.append(float(angle) / target.tolerance)
    truth = "true" if max(shares) <= 1 else "false"
    return Verdict(truth, f"{max(shares):.4g} tolerances from the goal's direction")


def _the_same(case: Case, motion: Trajectory) -> Verdict:
    """Judge a plan that differs from a good one by whole turns and signs alone."""
    pairs = zip(case.motion.x, motion.x, strict=True)
    off = max(float(case.judge.apart(a, b).max()) for a, b in pairs)
    return worst([graded(off / DEFECT * 10, "rows differ"), sound(case)])


def turns(case: Case, generator: Generator) -> Fault | None:
    """Add whole turns to angles of some rows, each row by itself."""
    entries = np.flatnonzero(case.judge.circular)
    if not entries.size:
        return None
    motion = replace(case.motion, x=case.motion.x.copy())
    whole = generator.integers(-3, 4, size=(len(motion.x), entries.size))
    whole[generator.random(len(motion.x)) < 0.5] = 0
    motion.x[:, entries] += 2 * np.pi * whole
    return Fault(case.problem, motion, _the_same(case, motion), "whole turns added to rows")


def signs(case: Case, generator: Generator) -> Fault | None:
    """Write some rows' quaternions with the other sign."""
    if not case.judge.attitudes:
        return None
    motion = replace(case.motion, x=case.motion.x.copy())
    for own in case.judge.attitudes:
        motion.x[generator.random(len(motion.x)) < 0.5, own] *= -1.0
    return Fault(case.problem, motion, _the_same(case, motion), "signs of quaternions changed")


def nearly_missed(case: Case, generator: Generator) -> Fault | None:
    """Move one target of the goal until the plan ends at 0.99 tolerances from it."""
    if not case.judge.knows:
        return None
    wanted, final = case.problem.goal, case.chained[-1]
    if not wanted.indices or wanted.norm != "max" or not np.isfinite(final).all():
        return None
    if float(case.judge.apart(final, case.motion.x[-1]).max()) > NEAR:
        return None
    i, sign = int(generator.integers(len(wanted.indices))), generator.choice([-1.0, 1.0])
    targets = np.array(wanted.targets)
    targets[i] = final[wanted.indices[i]] + sign * INSIDE * wanted.tolerances[i]
    problem = like(case.problem, goal=replace(wanted, targets=targets))
    return Fault(
        problem, case.motion, Verdict("true", f"{INSIDE} tolerances"), "a goal at its edge"
    )


def piece(case: Case, generator: Generator) -> Fault | None:
    """Take some rows of the plan from a row that becomes the start."""
    if case.steps < 4:
        return None
    first, last = sorted(generator.choice(case.steps + 1, 2, replace=False).tolist())
    motion = case.motion.piece(first, last)
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE)
    return Fault(problem, motion, sound(case), f"rows {first} to {last}")


def divided(case: Case, generator: Generator) -> Fault | None:
    """Put rows between others, at states that the judge finds; their inputs go on."""
    if not case.steps or not case.judge.knows or case.judge.law is not None:
        return None  # a law would give another input at the new row
    motion, count = case.motion, min(5, case.steps)
    chosen = sorted(generator.choice(case.steps, count, replace=False).tolist())
    for k in reversed(chosen):
        part = float(generator.uniform(0.1, 0.9)) * float(motion.t[k + 1] - motion.t[k])
        between = case.judge.after(motion.x[k], motion.u[k], part)
        motion = replace(
            motion,
            t=np.insert(motion.t, k + 1, motion.t[k] + part),
            x=np.insert(motion.x, k + 1, between, axis=0),
            u=np.insert(motion.u, k + 1, motion.u[k], axis=0),
            references=np.insert(motion.references, k + 1, motion.references[k], axis=0),
        )
    new = [k + i + j for i, k in enumerate(chosen) for j in (0, 1)]
    verdict = worst([case.judge.rows(motion, new), sound(case)])
    return Fault(case.problem, motion, verdict, "rows put between others")


def made_by_the_judge(case: Case, generator: Generator) -> Fault | None:
    """Follow inputs a little beside the plan's for some uneven steps, by the judge's integrator."""
    judge, old = case.judge, case.motion
    if not judge.knows or judge.margins is None or case.steps < 2:
        return None
    first = int(generator.integers(max(case.steps - ROWS, 1)))
    last = min(first + ROWS, case.steps)
    planned, limits = (old.u, judge.limits) if judge.law is None else (
        old.references, np.asarray(case.problem.model.control_bounds)
    )  # fmt: skip
    stir = STIRRED * np.ptp(limits, axis=1) * generator.normal(size=(last - first, len(limits)))
    held = np.clip(planned[first:last] + stir, *limits.T)
    spans = np.diff(old.t[first : last + 1]) * generator.uniform(0.5, 1.5, last - first)
    states, inputs = [old.x[first].copy()], []
    for row, span in zip(held, spans.tolist(), strict=True):
        u = row if judge.law is None else judge.law(states[-1], row)
        inputs.append(u)
        for part in np.full(LOOKS, span / LOOKS).tolist():
            if not (judge.margins(states[-1], u) > 0).all():
                return None
            states.append(judge.after(states[-1], u, part))
        if not (judge.margins(states[-1], u) > 0).all():
            return None
    states_at = np.array(states)
    low, high = np.asarray(case.problem.bounds).T
    room = MARGIN * judge.scales
    if not ((states_at >= low + room) & (states_at <= high - room)).all():
        return None
    references = held if judge.law is not None else np.zeros((len(held), 0))
    t = np.concatenate([[0.0], np.cumsum(spans)])
    motion = replace(old, t=t, x=states_at[::LOOKS], u=np.array(inputs), references=references)
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    problem = like(problem, rate_bounds=np.full_like(problem.rate_bounds, np.inf) * [-1.0, 1.0])
    return Fault(problem, motion, Verdict("true", "made by the judge"), f"from row {first}")


def hops(case: Case, generator: Generator) -> Fault | None:
    """Let a hopper hop by closed forms, as it does in tests of modes."""
    return hopped(generator, skips=False) if case.problem.machine.name in WALKS else None


def rewritten(case: Case, _generator: Generator) -> Fault | None:
    """Move the run's folder and write its rows with 17 digits."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made) / "elsewhere"
        shutil.copytree(case.folder, folder)
        table = folder / "trajectory.csv"
        lines = table.read_text().splitlines()
        rows = [",".join(_digits(entry) for entry in line.split(",")) for line in lines[1:]]
        table.write_text("\n".join([lines[0], *rows]) + "\n")
        run = read_run(folder)
    same = np.array_equal(run.trajectory.t, case.motion.t)
    same = same and np.array_equal(run.trajectory.x, case.motion.x)
    truth = Verdict("true" if same else "unknown", "the same numbers")
    return Fault(run.problem, run.trajectory, truth, "read from elsewhere, with 17 digits")


def _digits(entry: str) -> str:
    return f"{float(entry):.17g}" if entry else ""


KINDS: dict[str, Good] = {
    "as found": as_found,
    "whole turns": turns,
    "signs of quaternions": signs,
    "at the goal's edge": nearly_missed,
    "piece": piece,
    "rows between": divided,
    "made by the judge": made_by_the_judge,
    "17 digits, elsewhere": rewritten,
    "hops by closed forms": hops,
    "requirement of nested terms": nested.kept,
}
