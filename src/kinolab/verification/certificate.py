"""Is a plan true? Judged on a re-simulation that shares nothing with the planners.

The motion is integrated by SciPy's DOP853 from the start with the stored inputs; goal, limits and
collisions are judged on that curve, and every stored knot must follow from the one before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.analysis.consistent_states import CONSTRAINT_TOLERANCE
from kinolab.errors import SingularError
from kinolab.problem import Problem
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    ReferenceMotion,
    error_amplification,
    perturbed_start,
    reference_motion,
)
from kinolab.trajectory import Trajectory
from kinolab.verification.clearance_margin import ClearanceMargin, least_clearance
from kinolab.verification.dense_motion import MAX_SAMPLES, DenseMotion, TooFastError
from kinolab.world import NO_ENDS, CollisionChecker, World

Array: TypeAlias = NDArray[np.float64]

# of a state's scale: how far a knot may lie from where the one before leads
DEFECT_TOLERANCE = 1e-6
LIMIT_TOLERANCE = 1e-9  # by how much a limit may be passed, in its own unit: rounding only
# [m] of motion between two collision checks, at least; touching begins here too
MIN_RESOLUTION = 1e-5
MAX_DRIFT = 1e-3  # of a state's scale: beyond it the stored knots are not this motion
FEEDBACK_TOLERANCE = 1e-9  # of an input's range: how far it may be from what the law gives
DISCRETE_DEFECT = 1e-9  # of a state's scale, where the integrator's own map is the truth
# share by which a step of a discrete problem may differ: times add up with rounding
STEP_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: What was checked.
        value: The worst that was found.
        limit: The largest value that passes.
        passed: Whether it passed.
        detail: When, where and by how much, in words; empty where there is nothing to say.
    """

    name: str
    value: float
    limit: float
    passed: bool
    detail: str = ""

    def __str__(self) -> str:
        verdict = "passed" if self.passed else "FAILED"
        note = f": {self.detail}" if self.detail else ""
        return f"{verdict} {self.name} ({self.value:.3g}, limit {self.limit:.3g}){note}"


@dataclass(frozen=True)
class Certificate:
    """The outcome of all checks of a trajectory.

    Attributes:
        checks: In order.
        margin: The least room along the motion; None where it touches something or cannot be
            followed, and where there is nothing to collide with.
    """

    checks: tuple[Check, ...]
    margin: ClearanceMargin | None = None

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)


def verify(problem: Problem, trajectory: Trajectory) -> Certificate:
    """Check that a trajectory solves a problem: dynamics, limits, goal and collisions."""
    sound = _soundness(problem, trajectory)
    if not all(check.passed for check in sound):
        return Certificate(sound)  # nothing can be integrated
    trajectory, motion = _followed(problem, trajectory)
    feasible = (*sound, *_knot_checks(problem, trajectory))
    if isinstance(motion, DivergedError):
        return Certificate((*feasible, *_diverged(motion)))
    growth, walk = (
        _error_growth(problem, trajectory, motion),
        DenseMotion(problem, trajectory, motion),
    )
    collision = _collision(walk)
    return Certificate(
        (
            *feasible,
            *_requirements(walk),
            growth,
            _drift(problem, trajectory, motion, growth.value),
            _limits(walk),
            _goal(problem, motion),
            collision,
        ),
        least_clearance(walk) if collision.passed else None,
    )


def dynamics_checks(problem: Problem, trajectory: Trajectory) -> tuple[Check, ...]:
    """Check start, time, defects, constraints, inputs, requirements and the growth of errors."""
    sound = _soundness(problem, trajectory)
    if not all(check.passed for check in sound):
        return sound
    trajectory, motion = _followed(problem, trajectory)
    feasible = (*sound, *_knot_checks(problem, trajectory))
    if isinstance(motion, DivergedError):
        return (*feasible, *_diverged(motion))
    required = _requirements(DenseMotion(problem, trajectory, motion))
    return (*feasible, *required, _error_growth(problem, trajectory, motion))


def collision_check(problem: Problem, trajectory: Trajectory) -> Check:
    """Check that the re-simulated motion touches nothing."""
    unsound = [check for check in _soundness(problem, trajectory) if not check.passed]
    if unsound:
        return unsound[0]
    trajectory, motion = _followed(problem, trajectory)
    if isinstance(motion, DivergedError):
        return Check("collision", math.inf, 0.0, False, str(motion))
    return _collision(DenseMotion(problem, trajectory, motion))


def _followed(
    problem: Problem, trajectory: Trajectory
) -> tuple[Trajectory, ReferenceMotion | DivergedError]:
    """Return the true motion, and the stored knots in the numbers nearest to it.

    A state may be stored with whole turns more or less, and a quaternion with either sign: neither
    what is linear in it, such as a law of feedback, nor the growth of errors shall depend on that.
    """
    x = np.array(trajectory.x, dtype=float)
    x[0] = problem.space.nearest(problem.start, x[0])
    try:
        motion = reference_motion(problem, x[0], trajectory.t, trajectory.inputs)
    except DivergedError as error:
        return replace(trajectory, x=x), error
    return replace(trajectory, x=problem.space.nearest(motion.x, x)), motion


def motion_checks(
    problem: Problem, trajectory: Trajectory, motion: ReferenceMotion
) -> tuple[Check, ...]:
    """Check what a motion does on its way, whatever made it: all but whether it is true.

    Args:
        problem: With its requirements, limits, goal and obstacles.
        trajectory: With the inputs.
        motion: Under them.
    """
    walk = DenseMotion(problem, trajectory, motion)
    return (*_requirements(walk), _limits(walk), _goal(problem, motion), _collision(walk))


def difference(problem: Problem, a: Array, b: Array) -> Array:
    """Return a - b in units of the states' scales."""
    return problem.space.difference(b, a) / problem.scales


def _diverged(error: DivergedError) -> tuple[Check, Check]:
    grown = Check("error growth", math.inf, MAX_ERROR_AMPLIFICATION, False, str(error))
    return grown, Check("motion", math.inf, 0.0, False, str(error))


def _knot_checks(problem: Problem, trajectory: Trajectory) -> tuple[Check, ...]:
    """Check what concerns the stored knots alone."""
    return (
        _start(problem, trajectory),
        _defects(problem, trajectory),
        _constraints(problem, trajectory),
        _inputs(problem, trajectory),
        *_feedback(problem, trajectory),
    )


def _soundness(problem: Problem, trajectory: Trajectory) -> tuple[Check, Check]:
    """Check that all numbers are finite and that time begins at 0 and increases."""
    tables = {
        "t": trajectory.t,
        "x": trajectory.x,
        "u": trajectory.u,
        "references": trajectory.references,
    }
    broken = [name for name, table in tables.items() if not np.isfinite(table).all()]
    count = sum(int((~np.isfinite(table)).sum()) for table in tables.values())
    detail = f"not finite: {', '.join(broken)}" if broken else ""
    finite = _check("numbers", float(count), 0.0, detail)
    return finite, _time(problem, trajectory)


def _start(problem: Problem, trajectory: Trajectory) -> Check:
    errors = np.abs(difference(problem, trajectory.x[0], problem.start))
    k = int(errors.argmax())
    detail = (
        _named(problem, k, trajectory.x[0, k], problem.start[k])
        if errors[k] > LIMIT_TOLERANCE
        else ""
    )
    return _check("start", float(errors[k]), LIMIT_TOLERANCE, detail)


def _named(problem: Problem, k: int, found: float, wanted: float) -> str:
    return f"{problem.model.state_names[k]} is {found:.9g} where {wanted:.9g} is due"


def _time(problem: Problem, trajectory: Trajectory) -> Check:
    """Times start at 0 and increase, by whole steps where these are what the problem is made of.

    The value counts the steps that do not.
    """
    steps = np.diff(trajectory.t)
    bad, detail = np.flatnonzero(~(steps > 0)), "row {} does not come after the row before"
    if not bad.size and problem.scenario.integration.truth == "discrete":
        whole = np.isclose(steps, problem.step, rtol=STEP_TOLERANCE, atol=0.0)
        bad, detail = np.flatnonzero(~whole), "row {} does not come one step after the row before"
    cancelled = abs(float(trajectory.t[0])) > 0
    text = detail.format(bad[0] + 1) if bad.size else ""
    return _check(
        "time", float(bad.size + cancelled), 0.0, text or ("t starts late" if cancelled else "")
    )


def _defects(problem: Problem, trajectory: Trajectory) -> Check:
    """Follow the truth from every stored knot to the next and compare.

    With feedback it is the stored inputs, not the references, that must lead there.
    """
    discrete = problem.scenario.integration.truth == "discrete"
    limit = DISCRETE_DEFECT if discrete else DEFECT_TOLERANCE
    try:
        reached = _from_each(replace(problem, model=problem.model.plant), trajectory)
    except DivergedError as error:
        return Check("dynamics", math.inf, limit, False, str(error))
    errors = np.abs(difference(problem, trajectory.x[1:], reached))
    if not errors.size:
        return _check("dynamics", 0.0, limit, "")
    k, i = map(int, np.unravel_index(int(errors.argmax()), errors.shape))
    worst, named = float(errors[k, i]), _named(problem, i, trajectory.x[k + 1, i], reached[k, i])
    detail = f"at t = {trajectory.t[k + 1]:.6g} s {named}"
    return _check("dynamics", worst, limit, detail if worst > limit else "")


def _from_each(plant: Problem, trajectory: Trajectory) -> Array:
    """Return where the truth leads from every stored knot under the stored inputs, (N, nx)."""
    settings, t, x, u = plant.scenario.integration, trajectory.t, trajectory.x, trajectory.u
    if settings.truth != "discrete":
        spans = ((x[k], t[k : k + 2], u[k : k + 1]) for k in range(len(u)))
        ends = [reference_motion(plant, *one, between=False).x[-1] for one in spans]
        return np.array(ends).reshape(len(u), plant.model.nx)
    try:
        return plant.model.step(
            x[:-1], u, np.diff(t), method=settings.method, substeps=settings.substeps
        )
    except SingularError as error:
        raise DivergedError(float(t[error.row]), str(error)) from error


def _constraints(problem: Problem, trajectory: Trajectory) -> Check:
    held = np.vstack([trajectory.u, trajectory.u[-1:]]) if len(trajectory.u) else trajectory.u
    if not problem.system.constraints or not len(held):
        return _check("constraints", 0.0, CONSTRAINT_TOLERANCE, "")
    residual = np.abs(problem.model.plant.constraint_residual(trajectory.x, held))
    k, i = np.unravel_index(int(residual.argmax()), residual.shape)
    name = problem.model.residual_names[int(i)]
    worst = float(residual[k, i])
    detail = (
        f"at t = {trajectory.t[k]:.6g} s {name} is broken" if worst > CONSTRAINT_TOLERANCE else ""
    )
    return _check("constraints", worst, CONSTRAINT_TOLERANCE, detail)


def _inputs(problem: Problem, trajectory: Trajectory) -> Check:
    """Check that inputs, and the references of feedback, are within their limits."""
    model, plant = problem.model, problem.model.plant
    names, held, limits = plant.control_names, trajectory.u, plant.control_bounds
    if plant is not model:
        names, held = (*names, *model.control_names), np.hstack([held, trajectory.references])
        limits = np.vstack([limits, model.control_bounds])
    if not held.size:
        return _check("inputs", 0.0, LIMIT_TOLERANCE, "")
    lower, upper = limits.T
    excess = np.maximum(held - upper, lower - held)
    excess = np.where(np.isfinite(excess), excess, np.inf)
    k, i = np.unravel_index(int(excess.argmax()), excess.shape)
    worst = max(float(excess[k, i]), 0.0)
    detail = (
        f"at t = {trajectory.t[k]:.6g} s {names[int(i)]} is "
        f"{held[k, i]:.9g}, outside {lower[i]:g} to {upper[i]:g}"
    )
    return _check("inputs", worst, LIMIT_TOLERANCE, detail if worst > LIMIT_TOLERANCE else "")


def _feedback(problem: Problem, trajectory: Trajectory) -> Iterator[Check]:
    """Check that the stored inputs are what the law gives at the stored states."""
    model = problem.model
    if model.plant is model or not len(trajectory.u):
        return
    span = np.ptp(model.plant.control_bounds, axis=1)
    given = model.plant_inputs(trajectory.x[:-1], trajectory.references)
    errors = np.abs(trajectory.u - given) / span
    k, i = np.unravel_index(int(errors.argmax()), errors.shape)
    worst = float(errors[k, i])
    detail = (
        f"at t = {trajectory.t[k]:.6g} s {model.plant.control_names[int(i)]} is "
        f"{trajectory.u[k, i]:.9g} where the law gives {given[k, i]:.9g}"
    )
    yield _check(
        "feedback", worst, FEEDBACK_TOLERANCE, detail if worst > FEEDBACK_TOLERANCE else ""
    )


def _requirements(walk: DenseMotion) -> Iterator[Check]:
    """Check what the machine demands of plans, along the motion under the inputs held in it."""
    problem, named = walk.problem, walk.problem.system.requirements
    if not named or not len(walk.trajectory.u):
        return
    worst, detail = 0.0, ""
    try:
        for times, states, held in walk.samples():
            margins = problem.model.plant.requirements(states, held)
            short = np.where(np.isfinite(margins), -margins, np.inf)
            k, i = np.unravel_index(int(short.argmax()), short.shape)
            if short[k, i] > worst:
                worst = float(short[k, i])
                detail = f"at t = {times[k]:.6g} s {named[int(i)].name}: short by {worst:.4g}"
    except TooFastError as error:
        worst, detail = math.inf, str(error)
    yield _check("requirements", worst, LIMIT_TOLERANCE, detail if worst > LIMIT_TOLERANCE else "")


def _error_growth(problem: Problem, trajectory: Trajectory, motion: ReferenceMotion) -> Check:
    """Nudge the start and see how much farther from the motion the other one ends."""
    try:
        beside = perturbed_start(problem, trajectory.x[0])
        far = reference_motion(problem, beside, trajectory.t, trajectory.inputs, between=False)
    except DivergedError as error:
        return Check("error growth", math.inf, MAX_ERROR_AMPLIFICATION, False, str(error))
    grown = error_amplification(problem, motion.x, far.x)
    detail = (
        "too sensitive to be replayed without feedback" if grown > MAX_ERROR_AMPLIFICATION else ""
    )
    return _check("error growth", grown, MAX_ERROR_AMPLIFICATION, detail)


def _drift(
    problem: Problem, trajectory: Trajectory, motion: ReferenceMotion, grown: float
) -> Check:
    """Compare the stored knots with the motion from the start.

    Every knot may add a defect, and every defect grows as the motion makes errors grow.
    """
    errors = np.abs(difference(problem, trajectory.x, motion.x))
    worst = float(errors.max())
    k = int(errors.max(axis=1).argmax())
    limit = min(DEFECT_TOLERANCE * len(trajectory.t) * max(grown, 1.0), MAX_DRIFT)
    detail = f"largest at t = {trajectory.t[k]:.6g} s" if worst > limit else ""
    return _check("drift", worst, limit, detail)


def _goal(problem: Problem, motion: ReferenceMotion) -> Check:
    final = motion.x[-1]
    excess = problem.goal_excess(final)
    deviations = problem.goal.deviations(final)
    parts = [
        f"{problem.model.state_names[i]} is off by {abs(deviation):.4g}"
        for i, deviation, tolerance in zip(
            problem.goal.indices, deviations, problem.goal.tolerances, strict=True
        )
        if not abs(deviation) <= tolerance
    ]
    parts += [
        f"{attitude.name} is off by {attitude.turn(final):.4g} rad"
        for attitude in problem.goal.attitudes
        if not attitude.turn(final) <= attitude.tolerance
    ]
    other = "a point or an axis misses its target"
    if problem.goal.together and not problem.goal.needs_frames:
        whole = "sum" if problem.goal.norm == "sum" else "Euclidean norm"
        other = f"each deviation is within its tolerance, their {whole} is not"
    detail = "; ".join(parts) or other
    return _check("goal", excess, 1.0, detail if not excess <= 1.0 else "")


def _limits(walk: DenseMotion) -> Check:
    """Check limits at no more than SPACING of motion in between."""
    problem, worst, detail = walk.problem, 0.0, ""
    try:
        for times, states, _ in walk.samples():
            for j in np.flatnonzero(problem.outside_limits(states)):
                for name, value, lower, upper in problem.limit_violations(states[j]):
                    if max(value - upper, lower - value) > worst:
                        worst = max(value - upper, lower - value)
                        detail = f"at t = {times[j]:.6g} s {name} is {value:.9g}, "
                        detail += f"outside {lower:g} to {upper:g}"
    except TooFastError as error:
        worst, detail = math.inf, str(error)
    return _check("limits", worst, LIMIT_TOLERANCE, detail)


def _collision(walk: DenseMotion) -> Check:
    """Show the first contact, or that there is none as far as the bound on the speed holds."""
    try:
        contact = _first_contact(walk) or _sinking(walk)
    except TooFastError as error:
        contact = str(error)
    return _check("collision", float(bool(contact)), 0.0, contact)


def _first_contact(walk: DenseMotion) -> str:
    """Walk along the motion in steps that no point can use up the room in; empty where it is free.

    From a state with some room left, nothing can be touched before a point has moved that far.
    Room that is left over at the end of an integrator step serves the next one.

    Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative
    advancement).
    """
    look, motion = _look_of(walk.problem), walk.motion
    clearance, contact = look(float(motion.t[0]), motion.x[0])
    for k, begin, end, speed in walk.steps.rows():
        time, looks = begin, 0
        while not contact and clearance < speed * (end - time):
            time, looks = time + clearance / speed, looks + 1
            if looks > MAX_SAMPLES:
                raise TooFastError(begin, end, speed)
            clearance, contact = look(time, motion.between(k, np.array([time]))[0])
        clearance -= speed * (end - time)
        if contact:
            return contact
    return contact or look(float(motion.t[-1]), motion.x[-1])[1]


def _look_of(problem: Problem) -> Callable[[float, Array], tuple[float, str]]:
    """Return the question how far every point may move from a state, and what it touches."""
    checker = problem.checker()

    def look(time: float, x: Array) -> tuple[float, str]:
        placement = problem.placement(x)
        clearance = checker.clearance(*placement)
        if clearance == 0.0 and checker.collides(*placement):
            return 0.0, _described(checker, placement, time)
        return max(clearance, MIN_RESOLUTION), ""

    return look


def _sinking(walk: DenseMotion) -> str:
    """Look for wheels and feet in the ground, for which clearance leaves the ground out."""
    problem = walk.problem
    rest = any(body.touches_ground for body in problem.bodies)
    if not (rest and problem.world.ground):
        return ""
    checker = CollisionChecker(problem.bodies, World(ground=True))
    for times, states, _ in walk.samples():
        poses = problem.model.frames(states)
        k = checker.first_collision(poses)
        if k is not None:
            return _described(checker, (poses[k], NO_ENDS), times[k])
    return ""


def _described(checker: CollisionChecker, placement: tuple[Array, Array], time: float) -> str:
    contact = checker.contacts(*placement)[0]
    return f"at t = {time:.6g} s {contact.body} {contact.kind} {contact.obstacle}"


def _check(name: str, value: float, limit: float, detail: str) -> Check:
    return Check(name, value, limit, bool(value <= limit), detail)
