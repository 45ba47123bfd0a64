"""A duration that no plan of a problem falls below: proved, whatever the control and the path.

Every plan takes the machine from the start into the goal region. So each coordinate with a target,
each body whose place the goal decides, and each axis that it points, has some way to go, and goes
it no faster than limits and forces let anything move. The longest of these times is the bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinolab.dynamics.codegen.mode_formulas import ModeFormulas
from kinolab.dynamics.derivation.expression_graph import Operation
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import DirectionTarget, angle_between
from kinolab.store import code_in, pickled
from kinolab.verification.lower_bound.blocked_squares import free_way
from kinolab.verification.lower_bound.shortest_path import arc_outside
from kinolab.verification.lower_bound.speed_envelope import (
    FAR,
    AdmissibleStates,
    Cover,
    Measure,
    along,
    magnitude,
    turning,
)
from kinolab.world.distances.distance_field import digest

# Of a bound: verified motions may miss limits, start and equations of motion by less than that.
SLACK = 1e-6
# Boxes are halved until a bound has not grown by this share of itself for so many rounds, or there
# are so many boxes. Other values make bounds smaller, or take longer; they never make one false.
WORTH, PATIENCE, BOXES = 1e-3, 8, 3000
TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class DurationBound:
    """A duration in [s] that no plan falls below, and why.

    Attributes:
        seconds: The duration; 0 where nothing was proved.
        reason: What takes that long, or why nothing was proved.
    """

    seconds: float
    reason: str

    def sentence(self, duration: float) -> str:
        """Say how far above the bound a plan of a duration in [s] is at most."""
        if not self.seconds > 0.0:
            return f"no lower bound on its duration was proved: {self.reason}"
        shown = f"{math.floor(100.0 * self.seconds) / 100.0:g} s"
        # times a bound: a plan that is longer may or may not be a good one
        if duration > 2.0 * self.seconds:
            return (
                f"no plan takes less than {shown}, which is proved ({self.reason}), "
                "but says little so far below this one"
            )
        above = math.ceil(100.0 * (duration / self.seconds - 1.0))
        return f"at most {above} % above the proved lower bound of {shown} ({self.reason})"


@dataclass(frozen=True, eq=False)
class Way:
    """Something that has a way to go.

    Attributes:
        reason: What has which way to go, in words.
        length: Of the way at least, in [m] or [rad].
        rates: The places of its rates among a mode's.
        measure: Gives its speed.
    """

    reason: str
    length: float
    rates: tuple[int, ...]
    measure: Measure


KEPT = pickled("duration_bound", DurationBound)


def duration_bound(problem: PlanningTask) -> DurationBound:
    """Return a duration that no plan of a problem falls below; kept on disk, as it takes seconds.

    It holds for exact motions within all limits; those that are verified come as near to them as
    the verifier's tolerances, for which a millionth is taken off.
    """
    if problem.goal.any_of:
        ways = (duration_bound(replace(problem, goal=one)) for one in problem.goal.each)
        return min(ways, key=lambda bound: bound.seconds)
    world, plant = problem.world, problem.model.plant
    arrays = (problem.start, problem.bounds, problem.rate_bounds, plant.control_bounds)
    content = (
        code_in(Path(__file__).parents[1], Path(__file__).parents[2] / "problem"),
        plant.key,
        digest(world.obstacles),
        repr((world.bounds, world.clearance, problem.keep_outs, problem.bodies)),
        repr([problem.scenario.integration.truth, plant.parameter_vector().tolist()]),
        repr([array.tolist() for array in arrays]),
        repr([problem.goal.indices, problem.goal.targets.tolist(), problem.goal.points]),
        repr([problem.goal.tolerances.tolist(), problem.goal.directions]),
    )
    return KEPT.get(content, lambda: _proved(problem))


def _proved(problem: PlanningTask) -> DurationBound:
    if problem.scenario.integration.truth == "discrete":
        return DurationBound(0.0, "the integrator's own steps count, of which nothing is proved")
    modes = problem.model.plant.formulas
    ways = [way for way in _ways(problem, modes) if way.length > 0.0]
    times = [way.length / _fastest(problem, modes, way) for way in ways]
    if not max(times, default=0.0) > 0.0:
        return DurationBound(0.0, "nothing has to move, or nothing limits how fast it does")
    longest = times.index(max(times))
    seconds, way = times[longest], ways[longest]
    if len(modes) == 1:  # the end of a mode may be an impact, where speeds jump
        seconds = max(seconds, _with_forces(problem, modes[0], way))
    return DurationBound(seconds * (1.0 - SLACK), way.reason)


def _fastest(problem: PlanningTask, modes: tuple[ModeFormulas, ...], way: Way) -> float:
    """Return the largest speed of something in all states within limits."""
    tops = []
    for mode in modes:
        states = AdmissibleStates(problem, mode, _formulas(mode, way, forces=False))
        tops.append(_top_speed(states, states.root, way.measure))
    return max(tops)


def _top_speed(states: AdmissibleStates, box: Array, measure: Measure) -> float:
    cover = Cover.of(states, box[None], measure)
    slowest = _settled(states, cover, measure, lambda cover: 1.0 / max(cover.top, TINY))
    return 1.0 / slowest if slowest > 0.0 else math.inf


def _with_forces(problem: PlanningTask, mode: ModeFormulas, way: Way) -> float:
    """Return the least time that a way takes with what forces let speeds change."""
    states = AdmissibleStates(problem, mode, _formulas(mode, way, forces=True))
    start, end = (
        _top_speed(states, box, way.measure) for box in (states.at(problem.start), states.goal())
    )

    def least_time(cover: Cover) -> float:
        return cover.limits().least_time(way.length, start, end)

    whole = Cover.of(states, states.root[None], way.measure)
    # As fast it is at most at the end of the way, however little is known of forces yet.
    reach = 2.0 * max(float(whole.change.high.max(initial=0.0)), 0.0) * way.length
    whole = replace(whole, far=min(math.sqrt(start**2 + reach) * (1.0 + SLACK), FAR))
    return _settled(states, whole, way.measure, least_time)


def _settled(
    states: AdmissibleStates, cover: Cover, measure: Measure, bound: Callable[[Cover], float]
) -> float:
    """Return a bound that grows while a cover becomes finer, when it hardly grows any more."""
    bounds = [bound(cover)]
    while 0 < len(cover.boxes) < BOXES:
        cover = cover.halved(states, measure)
        bounds.append(max(bounds[-1], bound(cover)))
        if (
            not bounds[-1] > (1.0 + WORTH) * bounds[max(len(bounds) - 1 - PATIENCE, 0)]
            and len(bounds) > PATIENCE
        ):
            break
    return bounds[-1]


def _formulas(mode: ModeFormulas, way: Way, *, forces: bool) -> Formulas:
    """Return rates and their changes, of which nothing is known without forces."""
    rates = mode.rates.part(way.rates)
    unknown = Formulas((Operation("const", value=math.nan),), (0,) * len(way.rates))
    return rates.beside(mode.accelerations.part(way.rates) if forces else unknown)


def _ways(problem: PlanningTask, modes: tuple[ModeFormulas, ...]) -> Iterator[Way]:
    """Yield what the goal moves, but for what jumps where a mode ends."""
    jumping = _reset(problem)
    goal, model = problem.goal, problem.model
    gaps, reaches = goal.deviations(problem.start).tolist(), goal.tolerances.tolist()
    rows = zip(goal.indices, gaps, reaches, goal.circular, strict=True)
    for i, gap, reach, circular in rows:
        name = model.state_names[i]
        if i < model.nq and name not in jumping:
            length = abs(gap) - reach
            unit = next(c.unit for c in problem.machine.coordinates if name in c.entries)
            measure = magnitude if circular else along(gap)  # either way round
            yield Way(f"{name} has {length:.3g} {unit} to go", length, (i,), measure)
    frames = problem.frames(problem.start)
    for target in goal.directions:
        length = _arc(problem, target, target.in_world(frames))
        first = model.nq + 6 * target.body + 3
        reason = f"an axis of {problem.bodies[target.body].name} has {length:.3g} rad to turn"
        yield Way(reason, length, (first, first + 1, first + 2), turning(target.axis))
    if not any(mode.signs.ends for mode in modes):
        for k in problem.moving.tolist():
            length = _distance(problem, modes, k, frames[k, 3::4], jumping)
            reason = f"{problem.bodies[k].name} has {length:.3g} m to go"
            first = model.nq + 6 * k
            yield Way(reason, length, (first, first + 1, first + 2), magnitude)


def _reset(problem: PlanningTask) -> set[str]:
    """Return the names of coordinates that transitions reset."""
    if not problem.machine.modes:
        return set()
    return {str(entry) for one in problem.system.transitions for entry, _ in one.reset}


def _arc(problem: PlanningTask, target: DirectionTarget, start: Array) -> float:
    """Return how far an axis has to turn at least, in [rad], past any one cone."""
    goal = np.asarray(target.target)
    arc = float(angle_between(start, goal))
    for cone in problem.keep_outs:
        centre = np.asarray(cone.direction)
        room = float(angle_between(goal, centre)) - cone.half_angle
        if cone.body == target.body and cone.axis == target.axis and room > target.tolerance:
            arc = max(arc, arc_outside(start, goal, centre, cone.half_angle))
    return arc - target.tolerance


def _distance(
    problem: PlanningTask,
    modes: tuple[ModeFormulas, ...],
    k: int,
    start: Array,
    jumping: set[str],
) -> float:
    """Return how far a body's origin has to go at least, in [m], round obstacles in the plane."""
    least = math.inf
    for mode in modes:
        states = AdmissibleStates(
            problem, mode, mode.frames.part(range(12 * k + 3, 12 * k + 12, 4))
        )
        if jumping & {states.names[i] for i in states.used}:
            return 0.0
        found, _ = states.enclosed(states.goal()[None])
        low, high = (np.array([getattr(one, end)[0] for one in found]) for end in ("low", "high"))
        for point in problem.goal.points:
            if point.body == k and not any(point.at):
                low = np.maximum(low, np.asarray(point.position) - point.tolerance)
                high = np.minimum(high, np.asarray(point.position) + point.tolerance)
        away = float(np.linalg.norm(np.maximum(np.maximum(low - start, start - high), 0.0)))
        least = min(least, max(away, free_way(problem, mode, k, start, low, high)))
    return least
