"""Planning again at 10 Hz, against a machine that is disturbed and an obstacle that jumps.

    python benchmarks/replanning.py rolling_disk_maze diffdrive_warehouse --seconds 60 --seed 1

Each 0.1 s the machine's state is read, a question is asked about where it will be 0.1 s later, and
the answer is followed from then on. What it is answered is integrated by SciPy's DOP853 from where
the machine really is, with a disturbance of its pose at each period, and FCL is asked at 1 ms
whether it touches anything. Where it has arrived, it begins anew. A ball as large as the machine
jumps at random, never nearer to it than its stop needs.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import numpy as np

import kinolab
from kinolab.api import Problem
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.moved import with_obstacles_at
from kinolab.simulation.reference import reference_motion
from kinolab.solve.replanning.replanner import Replan, Replanner
from kinolab.trajectory import Trajectory
from kinolab.world import CollisionChecker

PERIOD = 0.1  # [s]
FINE = 1e-3  # [s] between poses that are held against FCL
DISTURBED = 1e-3  # standard deviation of each coordinate each period, in [m] and [rad]
JUMP = 0.3  # [m] of the obstacle each second
NAME = "ball"


@dataclass
class Tally:
    """What came of the questions.

    Attributes:
        seconds: Of each answer, by how it was made.
        touched: Contacts of the machine.
        arrived: How often it came to the goal.
        missing: Stops that were asked for, and not there.
    """

    seconds: dict[str, list[float]] = field(default_factory=dict)
    touched: int = 0
    arrived: int = 0
    missing: int = 0

    def __str__(self) -> str:
        every = np.array([s for group in self.seconds.values() for s in group]) * 1e3
        made = [t for by, group in self.seconds.items() if by != "stop" for t in group]
        kinds = ", ".join(f"{len(group)} {by}" for by, group in sorted(self.seconds.items()))
        median, most = np.percentile(1e3 * np.array(made), [50, 99]) if made else (np.nan, np.nan)
        return (
            f"{len(every)} answers: {kinds}; median {median:.1f} ms, 99 % within {most:.1f} ms, "
            f"{(every > 1e3 * PERIOD).sum()} beyond the period; "
            f"arrived {self.arrived} times, {self.touched} contacts"
        )


def with_ball(problem: Problem, rng: np.random.Generator) -> Problem:
    """Return the problem with one more obstacle, on its way and not at its ends."""
    way = problem.solve(improve=2.0).trajectory
    assert way is not None
    place = problem.frames(way.at(0.5 * way.duration).x)[0, [3, 7, 11]]
    place[:2] += rng.normal(size=2)
    return problem.with_obstacle(NAME, sphere=0.15, position=place.tolist())


def loop(problem: Problem, seconds: float, rng: np.random.Generator, *, paced: bool) -> Tally:
    """Ask for so many seconds of the machine's time; ``paced``, no sooner than the clock says."""
    tally, plan = Tally(), problem.solve(improve=2.0)
    replanner = problem.replanner(plan, deadline=0.95 * PERIOD, period=PERIOD)
    first = replanner.last
    checker, state, begun = problem.checker(), problem.start, time.monotonic()
    for k in range(round(seconds / PERIOD)):
        answer = replanner.last
        ahead = followed(replanner.problem, answer, state, PERIOD)
        moved = jumped(replanner, ahead, rng) if k % 10 == 0 else None
        asked = replanner.replan(ahead.x[-1], PERIOD, moved)
        tally.seconds.setdefault(asked.by, []).append(asked.seconds)
        if moved:
            checker = asked.problem.checker()
        tally.touched += touches(replanner.problem, checker, ahead)
        state = ahead.x[-1] + disturbance(problem, rng)
        if asked.by != "stop" and asked.trajectory.duration <= PERIOD:
            tally.arrived += 1
            state = problem.start
            replanner.follow(first)
        if paced:
            time.sleep(max(0.0, begun + (k + 1) * PERIOD - time.monotonic()))
    return tally


def followed(problem: PlanningTask, answer: Replan, state: Array, seconds: float) -> Trajectory:
    """Integrate what a machine does under an answer from where it really is."""
    t = np.arange(0.0, seconds + 0.5 * FINE, FINE)
    motion, moving = answer.trajectory, t[:-1] < answer.trajectory.duration
    inputs = np.tile(problem.model.null_control(), (len(moving), 1))  # once it stands
    if moving.any():
        held = motion.at(t[:-1][moving])
        inputs[moving] = held.references if motion.reference_names else held.u
    made = reference_motion(problem, state, t, inputs, between=False)
    return Trajectory(t, made.x, inputs, problem.model.state_names, problem.model.control_names)


def jumped(
    replanner: Replanner, ahead: Trajectory, rng: np.random.Generator
) -> dict[str, tuple[float, ...]]:
    """Return a new place of the ball, out of the way of the stop that is proved."""
    problem, stop = replanner.problem, replanner.stop
    entry = next(e for e in problem.scenario.world.obstacle if e.name == NAME)
    for _ in range(100):
        step = rng.normal(size=2)
        place = np.add(entry.position, np.append(JUMP * step / np.linalg.norm(step), 0.0))
        there = with_obstacles_at(problem, {NAME: tuple(place)}).checker()
        ways = np.vstack([stop.trajectory.x, ahead.x])
        if there.first_collision(problem.model.frames(ways)) is None:
            return {NAME: tuple(map(float, place))}
    return {}


def touches(problem: PlanningTask, checker: CollisionChecker, ahead: Trajectory) -> int:
    """Return how many poses of a motion touch something."""
    return sum(checker.collides(*problem.placement(x)) for x in ahead.x)


def disturbance(problem: PlanningTask, rng: np.random.Generator) -> Array:
    """Return what moves a state beside where it should be; rates are as they were."""
    nudge = np.zeros(problem.model.nx)
    nudge[: problem.model.nq] = DISTURBED * rng.normal(size=problem.model.nq)
    return nudge


def main() -> None:
    """Print a line for each scenario."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="+")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--unpaced", action="store_true", help="do not wait for the clock")
    asked = parser.parse_args()
    for name in asked.scenarios:
        rng = np.random.default_rng(asked.seed)
        problem = with_ball(kinolab.load(name), rng)
        print(f"{name}: {loop(problem, asked.seconds, rng, paced=not asked.unpaced)}", flush=True)


if __name__ == "__main__":
    main()
