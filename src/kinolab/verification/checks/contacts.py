"""Collision check of the re-simulated motion, by exact clearances and not planners' bounds."""

from __future__ import annotations

import math

from kinolab.numerics.arrays import Array
from kinolab.verification.between_samples.dense_motion import DenseMotion, TooFastError
from kinolab.verification.checks.check import Check, CheckContext, judged
from kinolab.world import CollisionChecker


def collision(context: CheckContext) -> Check:
    """Report the first contact, or none provided that the speed bound holds."""
    try:
        search, contact = context.clearance_search, ""
        search.narrow(lambda: 0.0)
        if math.isfinite(search.contact):
            placement = context.problem.placement(search.touching)
            contact = _described(search.checker, placement, search.contact)
        contact = contact or _sinking(context.dense_motion)
    except TooFastError as error:
        contact = str(error)
    return judged("collision", float(bool(contact)), 0.0, contact)


def _sinking(dense: DenseMotion) -> str:
    """Check for wheels and feet below the ground, which their clearance ignores."""
    problem = dense.problem
    rest = any(body.touches_ground for body in problem.bodies)
    if not (rest and problem.world.ground):
        return ""
    checker = problem.ground_checker()
    for times, states, _ in dense.samples():
        k = checker.first_collision(*problem.placement(states))
        if k is not None:
            return _described(checker, problem.placement(states[k]), times[k])
    return ""


def _described(checker: CollisionChecker, placement: tuple[Array, Array], time: float) -> str:
    """Say what touches; a pose that cannot be judged counts as touching, and nothing is named."""
    found = checker.contacts(*placement)
    if not found:
        return f"at t = {time:.6g} s something touches"
    return f"at t = {time:.6g} s {found[0].body} {found[0].verb} {found[0].obstacle}"
