"""Faults of machines: plans that a machine a little different makes, or one that breaks a rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import sympy

from kinolab.problem.goal import Goal
from kinolab.trajectory import Trajectory
from kinolab.world import World
from mutation_study import by_hand
from mutation_study.faults import Array, Case, Fault, Generator, Kind
from mutation_study.judge import WALKS, Judge, law_of, worst
from mutation_study.worlds import like

OFF = 0.01  # share by which a parameter or a gain is off
ROWS = 25  # that are made anew, at most
ANYWHERE = Goal((), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))
EMPTY = World()


def made_again(
    case: Case, judge: Judge, first: int, law: Callable[[Array, Array], Array] | None
) -> Trajectory:
    """Return some rows of a plan as a judge's machine follows the same inputs, or a law.

    Args:
        case: The plan.
        judge: Whose machine moves.
        first: Row from whose state on.
        law: That gives the inputs; None: they are the plan's.
    """
    old, last = case.motion, min(first + ROWS, case.steps)
    states, held = [old.x[first].copy()], []
    for k in range(first, last):
        u = old.u[k] if law is None else law(states[-1], old.references[k])
        held.append(u)
        states.append(judge.after(states[-1], u, float(old.t[k + 1] - old.t[k])))
    return replace(
        old,
        t=old.t[first : last + 1] - old.t[first],
        x=np.array(states),
        u=np.array(held),
        references=old.references[first:last],
    )


def parameter(case: Case, generator: Generator) -> Fault | None:
    """Let a machine with one parameter off by 1 % follow the plan's inputs, or its references."""
    values = case.judge.system.parameter_values
    names = [name for name, value in values.items() if value]
    if not names or not case.judge.knows or case.judge.problem.machine.name in WALKS:
        return None
    name = str(generator.choice(names))
    off = float(generator.choice([-OFF, OFF]))
    other = Judge(case.problem, **{name: values[name] * (1 + off)})
    first = int(generator.integers(max(case.steps - ROWS, 1)))
    motion = made_again(case, other, first, case.judge.law)
    if not np.isfinite(motion.x).all():
        return None
    every = range(len(motion.u))
    verdict = worst([case.judge.rows(motion, every), case.judge.feedback(motion, every)])
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    return Fault(problem, motion, verdict, f"{name} is off by {100 * off:g} %")


def gain(case: Case, generator: Generator) -> Fault | None:
    """Let a law with one term off by 1 % give the inputs: all else follows from them."""
    if case.judge.law is None or not case.judge.knows:
        return None
    changed: list[str] = []
    law = law_of(case.problem, lambda entries: _one_off(entries, generator, changed))
    first = int(generator.integers(max(case.steps - ROWS, 1)))
    motion = made_again(case, case.judge, first, law)
    if not np.isfinite(motion.x).all():
        return None
    every = range(len(motion.u))
    verdict = worst([case.judge.feedback(motion, every), case.judge.rows(motion, every)])
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    return Fault(problem, motion, verdict, changed[0])


def _one_off(entries: list[Any], generator: Generator, changed: list[str]) -> list[Any]:
    """Multiply one term of one sum in one of the law's expressions."""
    index = int(generator.integers(len(entries)))
    sums = sorted(entries[index].atoms(sympy.Add), key=str)
    if not sums:
        changed.append(f"law {index}: the whole is off by 1 %")
        entries[index] = entries[index] * sympy.Float(1 + OFF)
        return entries
    one = sums[int(generator.integers(len(sums)))]
    term = one.args[int(generator.integers(len(one.args)))]
    there = sympy.Add(*(a for a in one.args if a != term), term * sympy.Float(1 + OFF))
    entries[index] = entries[index].xreplace({one: there})
    changed.append(f"law {index}: a term of {len(one.args)} is off by 1 %")
    return entries


def mode(case: Case, generator: Generator) -> Fault | None:
    """Walk on without noticing that a foot came down: the next steps stand on the wrong foot."""
    if case.judge.problem.machine.name not in WALKS:
        return None
    roles = case.motion.x[:, -1]
    changes = np.flatnonzero(np.diff(roles) != 0)
    if not len(changes):
        return None
    k = int(generator.choice(changes))
    first, last = max(k - 2, 0), min(k + 4, case.steps)
    old = case.motion
    states = [old.x[first].copy()]
    for row in range(first, last):
        span = float(old.t[row + 1] - old.t[row])
        states.append(by_hand.walked(states[-1], old.u[row], span, lands=row < k))
    span_of = slice(first, last)
    motion = replace(
        old,
        t=old.t[first : last + 1] - old.t[first],
        x=np.array(states),
        u=old.u[span_of],
        references=old.references[span_of],
    )
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    verdict = case.judge.rows(motion, range(len(motion.u)))
    return Fault(problem, motion, verdict, f"row {k}: a foot that comes down is not noticed")


KINDS: dict[str, Kind] = {"parameter": parameter, "gain": gain, "mode skipped": mode}
