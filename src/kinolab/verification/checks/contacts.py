"""Collision check of the re-simulated motion, by exact clearances and not planners' bounds."""

from __future__ import annotations

import math

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.verification.check import Check, CheckContext, judged
from kinolab.verification.clearance_search import ClearanceSearch
from kinolab.verification.dense_motion import DenseMotion, TooFastError
from kinolab.world import CollisionChecker


def collision(context: CheckContext) -> Check:
    """Report the first contact, or none provided that the speed bound holds."""
    try:
        contact = _first_contact(context.clearance_search) or _sinking(context.dense_motion)
    except TooFastError as error:
        contact = str(error)
    return judged("collision", float(bool(contact)), 0.0, contact)


def _first_contact(search: ClearanceSearch) -> str:
    """Find the first contact; empty if there is none."""
    search.narrow(lambda: 0.0)
    if not math.isfinite(search.contact):
        return ""
    motion = search.dense.motion
    k = max(int(np.searchsorted(motion.t, search.contact)) - 1, 0)
    x = motion.between(k, np.array([search.contact]))[0] if len(motion.t) > 1 else motion.x[0]
    return _described(search.checker, search.dense.problem.placement(x), search.contact)


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
    contact = checker.contacts(*placement)[0]
    return f"at t = {time:.6g} s {contact.body} {contact.kind} {contact.obstacle}"
