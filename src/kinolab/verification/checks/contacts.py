"""Collision check of the re-simulated motion, by exact clearances and not planners' bounds."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.check import Check, CheckContext, judged
from kinolab.verification.dense_motion import MAX_SAMPLES, DenseMotion, TooFastError
from kinolab.world import NO_ENDS, CollisionChecker, World

# [m] least motion between two collision checks; also the contact tolerance
MIN_RESOLUTION = 1e-5


def collision(context: CheckContext) -> Check:
    """Report the first contact, or none provided that the speed bound holds."""
    motion = context.dense_motion
    try:
        contact = _first_contact(motion) or _sinking(motion)
    except TooFastError as error:
        contact = str(error)
    return judged("collision", float(bool(contact)), 0.0, contact)


def _first_contact(dense: DenseMotion) -> str:
    """Find the first contact by conservative advancement; empty if there is none.

    Nothing can be touched before a point has moved by the current clearance. What remains of it at
    the end of an integrator step carries over to the next.

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
    """Return the clearance at a state (nx,) in [m], and its contact, empty if none."""
    placement = problem.placement(x)
    clearance = checker.clearance(*placement)
    if clearance == 0.0 and checker.collides(*placement):
        return 0.0, _described(checker, placement, time)
    return max(clearance, MIN_RESOLUTION), ""


def _sinking(dense: DenseMotion) -> str:
    """Check for wheels and feet below the ground, which their clearance ignores."""
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
