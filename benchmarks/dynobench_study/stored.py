"""The benchmark's stored solutions, replayed by kinolab and judged by both."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints

from . import wheel
from .judgement import centre
from .problems import all_problems, environment
from .strict import miss

SOLUTIONS = ("idbastar_v0_solution_v0.yaml", "rrt_to_v0_solution_v0.yaml")
ALIKE = 1e-9  # of what both measure, rounding
TOUCHING = 2e-7  # [m] of overlap about which they need not agree: kinolab inflates by 1e-7 m


@dataclass(frozen=True)
class Replayed:
    """What both say of one stored solution.

    Attributes:
        problem: Its name.
        file: Of the solution.
        apart: Largest distance between kinolab's step and the authors', over all its states.
        ours: Goal distance, least gap in [m], and by how much inputs pass their limits, by kinolab.
        theirs: The same by the authors' code, and the largest jump.
        faults: Names of the checks of kinolab's verifier that it does not pass.
    """

    problem: str
    file: str
    apart: float
    ours: dict[str, float]
    theirs: dict[str, float]
    faults: tuple[str, ...]

    @property
    def disagreements(self) -> list[str]:
        """What one says and the other does not."""
        found = [] if self.apart <= ALIKE else [f"steps differ by {self.apart:.2g}"]
        if self.ours["goal"] < self.theirs["goal"] - ALIKE:
            found.append("kinolab's goal distance is the smaller one")
        if abs(self.ours["actions"] - self.theirs["actions"]) > ALIKE:
            found.append("limits of inputs differ")
        overlap = self.theirs["collision"]
        if abs(overlap) > TOUCHING and (self.ours["overlap"] > 0) != (overlap > 0):
            found.append("one sees a collision at a stored state")
        if overlap > TOUCHING and "collision" not in self.faults and "dynamics" not in self.faults:
            found.append("the verifier overlooks a collision")
        for check, measure in (("dynamics", "jump"), ("inputs", "actions"), ("start", "start")):
            if self.theirs[measure] > 10 * ALIKE and check not in self.faults:
                found.append(f"the verifier accepts {check}")
            # The authors' distance of attitudes is nothing up to half angles of 4 mrad.
            if self.theirs[measure] <= 0 and check in self.faults and check != "start":
                found.append(f"the verifier refuses {check}")
        return found


def report(replayed: list[Replayed]) -> Iterator[str]:
    """Yield sentences that say whether both agree, and what the verifier refuses."""
    agreed = sum(not one.disagreements for one in replayed)
    apart = max(one.apart for one in replayed)
    yield f"Of {len(replayed)} stored solutions both say the same of {agreed}."
    yield f"Steps differ by {apart:.1g} at most."
    for one in replayed:
        for what in one.disagreements:
            yield f"- {one.problem}, {one.file}: {what}"
    jump = max(one.theirs["jump"] for one in replayed)
    deepest = max(one.theirs["collision"] for one in replayed)
    yield f"Largest jump in them {jump:.1g}, deepest overlap {max(deepest, 0.0):.4f} m."
    names = sorted({name for one in replayed for name in one.faults})
    counts = (f"{name} in {sum(name in one.faults for one in replayed)}" for name in names)
    yield f"kinolab's verifier, which allows neither, refuses: {', '.join(counts)}."


def solutions(folder: Path, problems: list[str] | None = None) -> Iterator[tuple[str, Path]]:
    """Yield (problem, file) of the stored solutions of iDb-A* and RRT*+TO."""
    for problem in problems or all_problems():
        files = (folder / problem / name for name in SOLUTIONS)
        yield from ((problem, file) for file in files if file.exists())


def replay(folder: Path, problem: str, file: Path) -> Replayed:
    """Step through a stored solution with kinolab and with the authors' code.

    Args:
        folder: Of the environments.
        problem: Its name.
        file: Of the solution.
    """
    own = kinolab.load(environment(folder, problem))
    x, u = motion_in(file)
    robot, place = own.system.name, environment(folder, problem)
    stepped = own.model.step(x[:-1], u, own.step, method="euler")
    official = wheel.ask("steps", robot, place, x=x[:-1], u=u, dt=own.step)["x"]
    difference = stepped - official
    wrapped = (difference + np.pi) % (2 * np.pi) - np.pi
    apart = np.abs(np.where(own.model.circular, wrapped, difference)).max(initial=0.0)
    theirs = wheel.measures(robot, place, x, u, own.step, own.start, centre(own))
    theirs["collision"] = wheel.depth(robot, place, x)
    t, names = own.step * np.arange(len(x)), (own.model.state_names, own.model.control_names)
    failures = kinolab.verify(own, Trajectory(t, x, u, *names)).failures
    faults = tuple(check.name for check in failures)
    return Replayed(problem, file.name, float(apart), _ours(own, x, u), theirs, faults)


def _ours(
    problem: PlanningTask, x: NDArray[np.float64], u: NDArray[np.float64]
) -> dict[str, float]:
    lower, upper = problem.model.control_bounds.T
    return {
        "goal": miss(problem, x[-1]),
        "overlap": -CollisionConstraints(problem, 0.0).least(x),
        "actions": float(max((lower - u).max(), (u - upper).max())),
    }


def motion_in(file: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return states (N+1, nx) and inputs (N, nu) of a solution."""
    content: Any = yaml.safe_load(file.read_text(encoding="utf-8"))
    return np.array(content["states"], dtype=float), np.array(content["actions"], dtype=float)
