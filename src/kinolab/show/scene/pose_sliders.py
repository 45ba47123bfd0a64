"""Data for sliders with which a page puts a machine into a pose."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.dynamics.facts.machine_facts import CoordinateFacts
from kinolab.problem import PlanningTask

SCALES = 2.0  # of a coordinate without limits, to both sides of its start


def posing_of(problem: PlanningTask) -> dict[str, Any]:
    """Return the entries of the configuration with what sliders need, in their order.

    Each has a name, a unit, the ends of its slider, and the place of its rate among all rates:
    none of an attitude's, which has four entries and three rates.
    """
    sliders, rate = list[dict[str, Any]](), 0
    for coordinate in problem.machine.coordinates:
        alone = len(coordinate.entries) == len(coordinate.rates)
        for k, name in enumerate(coordinate.entries):
            place = len(sliders)
            lower, upper = _ends(coordinate, problem.start[place], problem.model.circular[place])
            own = {"name": name, "unit": coordinate.unit if alone else ""}
            at = rate + k if alone else None
            sliders.append({**own, "lower": lower, "upper": upper, "rate": at})
        rate += len(coordinate.rates)
    return {"sliders": sliders}


def room_of(problem: PlanningTask, posing: dict[str, Any]) -> dict[str, tuple[float, float]]:
    """Return how far the origins of bodies come by single sliders, in [m] by axes of the world."""
    ends = np.array([(slider["lower"], slider["upper"]) for slider in posing["sliders"]])
    states = np.repeat(problem.start[None], 2 * len(ends) + 1, axis=0)
    for k, pair in enumerate(ends):
        states[2 * k : 2 * k + 2, k] = pair
    places = problem.model.frames(states)[..., 3::4].reshape(-1, 3)
    low, high = places.min(axis=0).tolist(), places.max(axis=0).tolist()
    return dict(zip("xyz", zip(low, high, strict=True), strict=True))


def _ends(coordinate: CoordinateFacts, start: float, circular: bool) -> tuple[float, float]:
    if circular:
        return -math.pi, math.pi
    lower, upper = coordinate.limits
    lower = lower if math.isfinite(lower) else min(start, upper) - SCALES * coordinate.scale
    return lower, upper if math.isfinite(upper) else max(start, lower) + SCALES * coordinate.scale
