"""Which bodies pass through each other because no pair of them is named."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states
from kinolab.world import CollisionChecker, World

CORNERS = 64  # of the limits: six coordinates have so many
MOST = 3  # pairs that are named; more are counted


def passing_bodies(subject: Subject) -> tuple[str, tuple[Remark, ...]]:
    """Return a sentence about the bodies that meet at some states and at others do not.

    Where other pairs are named, these were hardly left out on purpose: a remark says so.
    """
    if not (through := _passing(subject)):
        return "", ()
    named = "; ".join(f"{a} and {b}" for a, b in through[:MOST])
    named += f"; {len(through) - MOST} further pairs" if len(through) > MOST else ""
    what = f"These may pass through each other, since no pair of them is named: {named}. "
    what += f"collisions=[{through[0]!r}] keeps two apart."
    closed = any(isinstance(c, PositionConstraint) for c in subject.system.constraints)
    # In a closed chain, limits do not say which poses are reached; a robot's file has pairs that
    # its reader chose, which leaves out neighbours and what touches at rest.
    if closed or not subject.system.collisions or subject.system.offers:
        return what, ()
    what = what.replace("no pair of them is named", "their pairs are not among the collisions")
    return "", (Remark("bodies pass through each other", "", what, ("System", "")),)


def _passing(subject: Subject) -> list[tuple[str, str]]:
    system, model = subject.system, subject.model
    solid = [body for body in system.bodies if body.shapes]
    geometry = [body for body in model.machine.bodies if body.shapes]
    watched = {frozenset(pair) for pair in (*system.collisions, *system.unwatched)}
    pairs = [(a.name, b.name) for a, b in combinations(solid, 2)]
    pairs = [pair for pair in pairs if frozenset(pair) not in watched]
    kept = [k for k, body in enumerate(system.bodies) if body.shapes]
    states = [model.rest()[None], random_states(model), _at_limits(subject)]
    frames = model.frames(np.vstack(states))[:, kept]
    return [pair for pair in pairs if _meets_sometimes(geometry, pair, frames)]


def _at_limits(subject: Subject) -> Array:
    """Return the states in which coordinates are at their limits, random ones of many, (n, nx)."""
    limited = [c for c in subject.plain if np.isfinite([c.lower, c.upper]).all()]
    states = np.repeat(subject.rest[None], CORNERS, axis=0)
    corners = np.random.default_rng(0).integers(0, 2, (CORNERS, len(limited)))
    if 2 ** len(limited) <= CORNERS:
        corners = np.arange(CORNERS)[:, None] >> np.arange(len(limited)) & 1
    for k, c in enumerate(limited):
        states[:, subject.plain[c]] = np.where(corners[:, k], c.upper, c.lower)
    return np.array([subject.on_constraints(x) for x in np.unique(states, axis=0)])


def _meets_sometimes(geometry: list[BodyGeometry], pair: tuple[str, str], frames: Array) -> bool:
    """Say whether two bodies touch at some of several poses, but not at all: not by a joint."""
    own = [k for k, body in enumerate(geometry) if body.name in pair]
    checker = CollisionChecker([geometry[k] for k in own], World(), self_pairs=[pair])
    found = [checker.collides(poses[own]) for poses in frames]
    return any(found) and not all(found)
