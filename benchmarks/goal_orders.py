"""Four goals in any order, against the best of all 24 orders, in worlds that are drawn.

    python benchmarks/goal_orders.py --worlds 10 --seed 1 --improve 2

A puck that is pushed along two axes rests in four places among boxes. The plan in any order is
compared with those in every order, leg by leg, each with the same work; a leg that begins and ends
where another one does is planned once. Returns 1 if more than one world in ten is more than 3 %
worse.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from itertools import pairwise, permutations
from typing import Any

import numpy as np

import kinolab
from kinolab.dynamics import Body, Force, Sphere, System, length, move

GOALS, BOXES, SIDE = 4, 8, 10.0  # of each world; [m]
RADIUS, ROOM = 0.15, 0.2  # [m] of the puck, and at least around goals
WORSE, MOST = 0.03, 0.1  # share of the best order's duration, and share of worlds beyond that


def puck() -> System:
    """A puck without friction, pushed along two axes."""
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    f = move(x, y, 0)
    body = Body("puck", f, mass=1.0, shape=Sphere(RADIUS))
    forces = [
        Force("px", on=body, along=f.x, limit=1.0),
        Force("py", on=body, along=f.y, limit=1.0),
    ]
    return System("puck", bodies=[body], inputs=forces)


def drawn(generator: np.random.Generator) -> tuple[list[dict[str, Any]], list[tuple[float, float]]]:
    """Draw boxes, and a start and goals away from them."""
    centres = generator.uniform(0.0, SIDE, (BOXES, 2))
    edges = generator.uniform(0.5, 2.5, (BOXES, 2))
    places: list[tuple[float, float]] = []
    while len(places) <= GOALS:
        x, y = generator.uniform(0.5, SIDE - 0.5, 2).tolist()
        outside = np.abs([x, y] - centres) - 0.5 * edges
        if (outside.max(axis=1) > RADIUS + ROOM).all():
            places.append((x, y))
    boxes = [
        {"box": [*edge, 1.0], "position": [*centre, 0.0]}
        for edge, centre in zip(edges.tolist(), centres.tolist(), strict=True)
    ]
    return boxes, places


def asked(x: float, y: float) -> dict[str, Any]:
    """Return a goal at rest."""
    return {"x": x, "y": y, "at_rest": True, "tolerance": 0.05}


def problem(boxes: list[dict[str, Any]], start: tuple[float, float], **goals: Any) -> Any:
    """Return a problem in a world of boxes."""
    world = {"bounds": {"x": [0, SIDE], "y": [0, SIDE]}, "obstacle": boxes}
    begin = dict(zip("xy", start, strict=True))
    return kinolab.load({"system": puck(), "world": world, "start": begin, **goals})


def least(legs: Mapping[tuple[int, int], float]) -> tuple[float, tuple[int, ...]]:
    """Return the least duration of all orders, and that order; 0 is the start."""
    orders = permutations(range(1, GOALS + 1))
    return min((sum(legs[leg] for leg in pairwise((0, *order))), order) for order in orders)


def main() -> int:
    """Print a line for each world; return 1 if too many are worse."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worlds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--improve", type=float, default=2.0, help="work on each leg, in [s]")
    given = parser.parse_args()
    worse = 0
    print("| world | any order [s] | best of 24 [s] | above |\n|---|---|---|---|")
    for k in range(given.worlds):
        boxes, places = drawn(np.random.default_rng([given.seed, k]))
        *via, last = (asked(*place) for place in places[1:])
        whole = problem(boxes, places[0], via=via, goal=last | {"order": "any"})
        plan = whole.solve(seed=given.seed, improve=given.improve)
        legs = {
            (i, j): problem(boxes, places[i], goal=asked(*places[j])).solve(
                seed=given.seed, improve=given.improve
            )
            for i in range(GOALS + 1)
            for j in range(1, GOALS + 1)
            if i != j
        }
        infinite = float("inf")
        best, _ = least({leg: found.duration or infinite for leg, found in legs.items()})
        taken = plan.duration if plan.status == "solved" and plan.duration else infinite
        above = taken / best - 1.0
        worse += not above <= WORSE
        print(f"| {k + 1} | {taken:.2f} | {best:.2f} | {100 * above:.1f} % |", flush=True)
    print(f"{given.worlds - worse} of {given.worlds} within {WORSE:.0%} of the best order")
    return int(worse > MOST * given.worlds)


if __name__ == "__main__":
    sys.exit(main())
