"""Does the true motion touch anything? With a clearance of its own, shared with no planner."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.check import Check, CheckContext, judged
from kinolab.verification.dense_motion import MAX_SAMPLES, DenseMotion, TooFastError
from kinolab.world import NO_ENDS, CollisionChecker, World

# [m] of motion between two collision checks, at least; touching begins here too
MIN_RESOLUTION = 1e-5


def collision(context: CheckContext) -> Check:
    """Show the first contact, or that there is none as far as the bound on the speed holds."""
    motion = context.dense_motion
    try:
        contact = _first_contact(motion) or _sinking(motion)
    except TooFastError as error:
        contact = str(error)
    return judged("collision", float(bool(contact)), 0.0, contact)


def _first_contact(dense: DenseMotion) -> str:
    """Advance in steps in which no point can use up the clearance; empty where it is free.

    From a state with some clearance, nothing can be touched before a point has moved that far.
    What is left over of it at the end of an integrator step serves the next one.

    Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative
    advancement).
    """
    problem, motion, checker = dense.problem, dense.motion, dense.problem.checker()
    clearance, contact = _clearance_at(problem, checker, float(motion.t[0]), motion.x[0])
    for k, begin, end, speed in dense.steps.rows():
        time, count = begin, 0
        while not contact and clearance < speed * (end - time):
            time, count = time + clearance / speed, count + 1
            if count > MAX_SAMPLES:
                raise TooFastError(begin, end, speed)
            x = motion.between(k, np.array([time]))[0]
            clearance, contact = _clearance_at(problem, checker, time, x)
        clearance -= speed * (end - time)
        if contact:
            return contact
    return contact or _clearance_at(problem, checker, float(motion.t[-1]), motion.x[-1])[1]


def _clearance_at(
    problem: PlanningTask, checker: CollisionChecker, time: float, x: Array
) -> tuple[float, str]:
    """Return how far in [m] every point may move from a state, and what it touches."""
    placement = problem.placement(x)
    clearance = checker.clearance(*placement)
    if clearance == 0.0 and checker.collides(*placement):
        return 0.0, _described(checker, placement, time)
    return max(clearance, MIN_RESOLUTION), ""


def _sinking(dense: DenseMotion) -> str:
    """Look for wheels and feet in the ground, for which clearance leaves the ground out."""
    problem = dense.problem
    rest = any(body.touches_ground for body in problem.bodies)
    if not (rest and problem.world.ground):
        return ""
    checker = CollisionChecker(problem.bodies, World(ground=True))
    for times, states, _ in dense.samples():
        poses = problem.model.frames(states)
        k = checker.first_collision(poses)
        if k is not None:
            return _described(checker, (poses[k], NO_ENDS), times[k])
    return ""


def _described(checker: CollisionChecker, placement: tuple[Array, Array], time: float) -> str:
    contact = checker.contacts(*placement)[0]
    return f"at t = {time:.6g} s {contact.body} {contact.kind} {contact.obstacle}"
