"""Faults of machines: plans that a machine a little different makes, or one that breaks a rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import sympy
from scipy.optimize import brentq

import kinolab
from kinolab.problem import PlanningTask
from kinolab.problem.goal import Goal
from kinolab.trajectory import Trajectory
from kinolab.world import World
from tests.oracles.hopper import Hopper
from tests.switching_machines import hopper

from . import by_hand, nested
from .faults import Array, Case, Fault, Generator, Kind
from .judge import LIMIT, WALKS, Judge, Verdict, graded, law_of, worst
from .worlds import like

OFF = 0.01  # share by which a parameter or a gain is off
ROWS = 25  # that are made anew, at most
SAMPLES = 200  # of an interval, for limits and pulls
FEW_ROWS, STRIDE = 8, 4  # that bodies are followed for, and every so many of their samples
BEYOND = (-6.0, -2.0)  # decades of a scale by which a limit is passed
LACK = (-6.0, -1.0)  # decades of a pull in [N] that a rope lacks
DEPTHS = (-4.0, -2.0)  # decades in [m] by which parts overlap
WEAK = 0.5  # [m/s^2]
HOPS = 40  # rows of a hopper's motion
SEEN = 1e-4  # [m] below the ground, or [N] of its pull, from which on a missed change is certain
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
    """Multiply one of the law's expressions, or one term of one sum in it."""
    index = int(generator.integers(len(entries)))
    sums = sorted(entries[index].atoms(sympy.Add), key=str)
    if not sums or generator.random() < 0.5:
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
    """Walk, or hop, on without noticing that a foot came down, or left the ground."""
    if case.judge.problem.machine.name not in WALKS:
        return None
    if generator.random() < 0.5:
        return hopped(generator, skips=True)
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


def hopped(generator: Generator, *, skips: bool) -> Fault | None:
    """Hop by closed forms, a row at uneven times.

    Args:
        generator: Draws the height and the times.
        skips: Whether one landing, or one leaving of the ground, is not noticed: the motion goes on
            as that of the mode before.
    """
    problem, leg = _hopper(), Hopper()
    x, flies, clock = np.array([generator.uniform(1.0, 1.6), 0.0, 0.0, 0.0]), True, 0.0
    times = np.concatenate([[0.0], np.cumsum(generator.uniform(0.01, 0.06, HOPS))])
    until = leg.touch_down(x)  # of the mode's end, from its beginning
    rows, count, missed = [np.append(x, 1.0)], 0, -1
    skipped = int(generator.integers(2)) if skips else -1
    begin = x
    for row, time in enumerate(times[1:].tolist()):
        while clock + until <= time and count != skipped:
            clock, count = clock + until, count + 1
            end = leg.flight(begin, until) if flies else leg.stance(begin, until)
            begin, flies = leg.landing(end) if flies else end, not flies
            until = leg.touch_down(begin) if flies else leg.lift_off(begin)
        if clock + until <= time and missed < 0:
            missed = row
        now = leg.flight(begin, time - clock) if flies else leg.stance(begin, time - clock)
        rows.append(np.append(now, float(flies)))
    if skips and missed < 0:
        return None
    motion = Trajectory(times, np.array(rows), np.zeros((HOPS, 0)), problem.model.state_names, ())
    problem = like(problem, start=motion.x[0].copy())
    if not skips:
        return Fault(problem, motion, Verdict("true", "closed forms"), "a hopper hops")
    words = "flies below the ground" if flies else "hangs on the ground"
    place, _ = leg.foot(motion.x[missed + 1])
    pull = leg.k * motion.x[missed + 1, 1] - leg.m_f * leg.g
    sure = place < -SEEN if flies else pull > SEEN
    return Fault(problem, motion, Verdict("false" if sure else "borderline", words), words)


@cache
def _hopper() -> PlanningTask:
    table: dict[str, Any] = {
        "system": hopper(),
        "start": {"z": 1.2, "mode": 1},
        "goal": {"z": 1.0},
        "bounds": {"z": [-9, 9], "s": [-1, 1], "z_dot": [-50, 50], "s_dot": [-200, 200]},
    }
    return like(kinolab.load(table), goal=ANYWHERE, world=EMPTY)


def limit(case: Case, generator: Generator) -> Fault | None:
    """Lower a limit of a state just below the largest value that a piece of the plan takes.

    By how much is drawn between a millionth and a hundredth of its scale. The judge's samples are
    values that the motion has, so that the limit is passed at least so far.
    """
    judge = case.judge
    if judge.problem.machine.name in WALKS or not judge.knows or case.steps < 2:
        return None
    free = np.ones(len(judge.states), dtype=bool)
    for own in judge.attitudes:
        free[own] = False
    i = int(generator.choice(np.flatnonzero(free)))
    motion, seen = _piece(case, generator, ROWS)
    sign = float(generator.choice([-1.0, 1.0]))
    by = judge.scales[i] * float(10 ** generator.uniform(*BEYOND))
    least = float((sign * seen[..., i]).max()) - by
    if sign * motion.x[0, i] > least - by:
        return None  # the start, or nearly: it would be told to lie outside
    bounds = np.array(case.problem.bounds)
    bounds[i] = (-np.inf, least) if sign > 0 else (-least, np.inf)
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    problem = like(problem, bounds=bounds, circular=judge.circular & ~_only(i, len(judge.states)))
    verdict = graded(by / LIMIT, f"{judge.states[i]} is beyond its limit")
    where = "in rows, too" if np.max(sign * motion.x[:, i]) > least else "between rows only"
    return Fault(problem, motion, verdict, f"{judge.states[i]} by {by:.3g}, {where}")


def room(case: Case, generator: Generator) -> Fault | None:
    """Lower a limit of the workspace just below where a body goes, or widen a forbidden cone.

    As limits of states are, along fewer rows, by the judge's own frames.
    """
    judge = case.judge
    if judge.problem.machine.name in WALKS or not judge.knows or case.steps < 2:
        return None
    motion, seen = _piece(case, generator, FEW_ROWS)
    poses = [case.bodies.poses(x) for x in seen.reshape(-1, len(judge.states))[::STRIDE]]
    by = float(10 ** generator.uniform(*BEYOND))
    problem = like(case.problem, start=motion.x[0].copy(), goal=ANYWHERE, world=EMPTY)
    if case.problem.keep_outs:
        cone = case.problem.keep_outs[0]
        axes = np.array([pose[cone.body][:3, :3] @ np.array(cone.axis) for pose in poses])
        wanted = np.array(cone.direction)
        angles = np.arctan2(np.linalg.norm(np.cross(axes, wanted), axis=1), axes @ wanted)
        half = float(angles.min()) + by
        if angles[0] < half + by:
            return None
        problem = like(problem, keep_outs=(replace(cone, half_angle=half),))
        what = f"an axis enters a cone by {by:.3g} rad"
    else:
        axis = int(generator.integers(3))
        places = np.array([[pose[axis, 3] for pose in bodies] for bodies in poses]).max(axis=1)
        highest = float(places.max()) - by
        if places[0] > highest - by:
            return None
        bounds = {"xyz"[axis]: (-np.inf, highest)}
        problem = like(problem, world=World(bounds=bounds))
        what = f"a body leaves the workspace along {'xyz'[axis]} by {by:.3g} m"
    return Fault(problem, motion, graded(by / LIMIT, "a limit is passed"), what)


def _piece(case: Case, generator: Generator, rows: int) -> tuple[Trajectory, Array]:
    """Return some rows of a plan, and the judge's samples of their intervals, (n, samples, nx)."""
    first = int(generator.integers(max(case.steps - rows, 1)))
    motion = case.motion.piece(first, min(first + rows, case.steps))
    spans = np.diff(motion.t).tolist()
    each = zip(motion.x, motion.u, spans, strict=False)
    return motion, np.array([case.judge.between(x, u, span, SAMPLES) for x, u, span in each])


def _only(i: int, count: int) -> Any:
    chosen = np.zeros(count, dtype=bool)
    chosen[i] = True
    return chosen


def compressed(case: Case, generator: Generator) -> Fault | None:
    """Let a hoist lower its load so fast in one interval that the rope would have to push.

    Of two cranes in a weak field, whose hoists are stronger than it: nothing else is wrong. The
    pull by Newton's law along the rope is m (g cos s - x'' sin s - l'' + l s'^2).
    """
    if case.problem.machine.name != "two_cranes":
        return None
    problem = _in_a_weak_field()
    judge = Judge(problem)
    count, motion_x = int(generator.integers(3, 8)), [np.array(problem.start)]
    motion_x[0][judge.states.index("sway_a")] = generator.uniform(-0.3, 0.3)
    motion_x[0][judge.states.index("sway_a_dot")] = generator.uniform(-0.3, 0.3)
    spans = generator.uniform(0.1, 0.4, count)
    held = generator.uniform(-0.2, 0.2, (count, 4))
    wrong, lack = int(generator.integers(count)), float(10 ** generator.uniform(*LACK))
    for k, span in enumerate(spans.tolist()):
        if k == wrong:
            held[k, 1] = brentq(
                lambda hoist, k=k, span=span: (
                    _pull(judge, motion_x[-1], np.array([held[k, 0], hoist, *held[k, 2:]]), span)
                    + lack
                ),
                -0.5,
                1.0,
                xtol=1e-14,
            )
        motion_x.append(judge.after(motion_x[-1], held[k], span))
    states = np.array(motion_x)
    least = min(_pull(judge, states[k], u, spans[k]) for k, u in enumerate(held))
    low, high = np.asarray(problem.bounds).T
    if not ((states > low) & (states < high)).all():
        return None
    t = np.concatenate([[0.0], np.cumsum(spans)])
    motion = Trajectory(t, states, held, judge.states, problem.model.control_names)
    verdict = graded(-least / LIMIT, "the rope pushes")
    alone = like(problem, start=states[0].copy())
    return Fault(alone, motion, verdict, f"a rope pushes by {-least:.3g} N")


def touching(case: Case, generator: Generator) -> Fault | None:
    """Let the trolleys of two cranes meet and part again between two rows, by a millimetre or so.

    Their centres are g - 2 v t + a t^2 apart under accelerations of a each, and least so, by
    v^2 / a less, halfway; both are 0.8 m long.
    """
    if case.problem.machine.name != "two_cranes":
        return None
    problem = like(case.problem, goal=ANYWHERE, world=EMPTY)
    judge, deep = Judge(problem), float(10 ** generator.uniform(*DEPTHS))
    v, a = generator.uniform(0.1, 0.5), generator.uniform(0.5, 1.0)
    apart = 0.8 - deep + v**2 / a
    x = np.array(problem.start)
    for name, value in (("x_a", 5.0), ("x_b", 5.0 + apart), ("l_a", 2.0), ("l_b", 4.0)):
        x[judge.states.index(name)] = value
    x[judge.states.index("x_a_dot")], x[judge.states.index("x_b_dot")] = v, -v
    u, span = np.array([-a, 0.0, a, 0.0]), 2 * v / a
    states = np.array([x, judge.after(x, u, span)])
    motion = Trajectory(
        np.array([0.0, span]), states, u[None], judge.states, problem.model.control_names
    )
    verdict = Verdict("false", f"the trolleys overlap by {1000 * deep:.3g} mm")
    return Fault(like(problem, start=x), motion, verdict, f"trolleys {1000 * deep:.3g} mm too near")


def _pull(judge: Judge, x: Array, u: Array, span: float) -> float:
    """Return the least pull of the first crane's rope in an interval in [N]."""
    seen = judge.between(x, u, span, SAMPLES)
    l, s, s_dot = seen[:, 1], seen[:, 2], seen[:, 8]  # noqa: E741
    values = judge.values
    pull = values["g"] * np.cos(s) - u[0] * np.sin(s) - u[1] + l * s_dot**2
    return float(values["m"] * pull.min())


@cache
def _in_a_weak_field() -> PlanningTask:
    problem = kinolab.load("two_cranes", overrides=[f"system.parameters={{ g = {WEAK} }}"])
    return like(problem, goal=ANYWHERE, world=EMPTY)


KINDS: dict[str, Kind] = {
    "parameter": parameter,
    "gain": gain,
    "mode skipped": mode,
    "limit passed": limit,
    "workspace left": room,
    "string in compression": compressed,
    "own parts touch": touching,
    "requirement of nested terms": nested.broken,
}
