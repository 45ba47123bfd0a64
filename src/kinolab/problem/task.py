"""The planning task: a machine in a world with start, goal, limits, metric and sampling."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.dynamics.analysis.consistent_states import (
    constraint_violations,
    nearest_consistent_state,
)
from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.dynamics.facts.machine_facts import MachineFacts, member_of, members
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.errors import EndpointError, InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem.goal import Goal, KeepOutCone, PointTarget
from kinolab.problem.inverse_kinematics import reaching
from kinolab.problem.pointing import pointed
from kinolab.scenario import Scenario, place_at
from kinolab.scenario.values import ROBOT_FORMATS
from kinolab.world import NO_ENDS, BodyGeometry, CableGeometry, CollisionChecker, World
from kinolab.world.collision.contact_report import GROUND_NAME

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism

# a goal is called so only if the nearest of them misses by more than both; singular poses may do it
MISSED_TOLERANCES, MISSED_LENGTH = 2.0, 1e-3  # [m] or [rad]
LIMIT_TOLERANCE = 1e-9  # by which a value may exceed a limit, in its own unit
HORIZON = 60.0  # [s] of the time in which states are drawn, where no limit of it is given
SAME = 1e-12  # smaller differences are not printed
LEANING = " Draw a wheel that leans thin: the edge of its tread goes down."
LARGE_SOLIDS = (  # of a robot from a file
    " If only the solids around meshes do, convex_parts = 4 below [system] makes them smaller."
)


class Costly(Protocol):
    """A motion as ``cost_of`` needs it: a trajectory, or knots that are optimised."""

    @property
    def x(self) -> Array:
        """States, shape (N+1, nx)."""

    @property
    def duration(self) -> float:
        """In [s]."""


@dataclass(frozen=True, eq=False, repr=False)
class PlanningTask:
    """A planning problem.

    Attributes:
        scenario: The scenario with every default filled in.
        machine: What planning asks of the machine besides its model.
        model: The machine, compiled, with input limits tightened by [bounds].
        world: Obstacles, ground, and the limits of the workspace.
        start: State at time zero, shape (nx,).
        goal: The goal region.
        bounds: Lower and upper limit of each state entry, shape (nx, 2).
        rate_bounds: Limits of all rates q_dot, the dependent ones included, shape (nt, 2).
        scales: Characteristic magnitude of each state entry, shape (nx,).
        weights: Factors of state differences in the planner's metric, shape (nx,).
        circular: Which state entries are angles on the circle, shape (nx,).
        keep_outs: Cones that axes of bodies must stay out of.
        via: The goals that are reached on the way.
        whole: The machine with its full input limits; ``model`` when left out.
        alone: Where obstacles move, the machine without them: as ``whole``, and as ``model``.
        cost_entry: The entry of the state that is the cost so far, where there is one.
    """

    scenario: Scenario
    machine: MachineFacts
    model: Model
    world: World
    start: Array
    goal: Goal
    bounds: Array
    rate_bounds: Array
    scales: Array
    weights: Array
    circular: NDArray[np.bool_]
    keep_outs: tuple[KeepOutCone, ...] = ()
    via: tuple[Goal, ...] = ()
    whole: Model | None = None
    alone: tuple[Model, Model] | None = None
    cost_entry: int | None = None

    def __repr__(self) -> str:
        """Name the scenario, the machine and what stands in the way."""
        count = len(self.world.obstacles)
        things = f"{count} obstacle{'s' if count != 1 else ''}"
        return f"<{type(self).__name__} {self.name}: {self.machine.name}, {things}>"

    def __getstate__(self) -> dict[str, Any]:
        """Return the picklable state; collision checkers are rebuilt after unpickling."""
        rebuilt = ("_checker", "_ground_checker", "space")
        return {key: value for key, value in vars(self).items() if key not in rebuilt}

    @property
    def name(self) -> str:
        """The scenario's name."""
        return self.scenario.name

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about how the scenario was read and what is normal, good to know."""
        return (*self.scenario.origin.notes, *self.world.notes)

    @property
    def system(self) -> Mechanism:
        """The machine as it is described, with its full input limits; described on demand."""
        return (self.whole or self.model).system

    def cost_of(self, motion: Costly) -> float:
        """Return the duration of a motion in [s], or what it costs where that is a state."""
        entry = self.cost_entry
        return motion.duration if entry is None else float(np.ptp(motion.x[[0, -1], entry]))

    @property
    def step(self) -> float:
        """Length of one propagation step in [s]."""
        return self.scenario.integration.step

    @property
    def bodies(self) -> tuple[BodyGeometry, ...]:
        """The bodies' shapes with numeric dimensions."""
        return self.machine.bodies

    @cached_property
    def moving(self) -> NDArray[np.intp]:
        """Numbers of the bodies that move, for which the world's bounds hold."""
        return np.flatnonzero([body.moves for body in self.bodies])

    @cached_property
    def leading(self) -> int:
        """The number of the body whose path stands for the machine's: the first seen that moves."""
        moving = self.moving.tolist()
        seen = [k for k in moving if self.bodies[k].shapes or self.bodies[k].drawn]
        return next(iter((*seen, *moving)), 0)

    @cached_property
    def leaders(self) -> list[int]:
        """The number of the leading body, of several machines of each."""
        machines = members(self.machine.name)
        if not machines:
            return [self.leading]
        seen = [k for k in self.moving.tolist() if self.bodies[k].shapes or self.bodies[k].drawn]
        own = [member_of(self.bodies[k].name, machines) for k in seen]
        return [seen[own.index(machine)] for machine in machines if machine in own]

    @property
    def cables(self) -> tuple[CableGeometry, ...]:
        """The cables with numeric dimensions."""
        return self.machine.cables

    def checker(self, margin: float = 0.0) -> CollisionChecker:
        """Return a new collision checker, bodies and cables inflated by a margin in [m].

        Check a state x by ``checker.collides(*problem.placement(x))``.
        """
        return self._checker.inflated(margin, ground=self.world.ground)

    def ground_checker(self) -> CollisionChecker:
        """Return a new collision checker of the ground alone."""
        return self._ground_checker.inflated(0.0, ground=True)

    @cached_property
    def _ground_checker(self) -> CollisionChecker:
        return CollisionChecker(self.bodies, World(ground=True), cables=self.cables)

    @cached_property
    def _checker(self) -> CollisionChecker:
        """The prototype of all checkers: building the BVHs of large meshes is slow."""
        pairs = self.machine.collisions
        return CollisionChecker(self.bodies, self.world, cables=self.cables, self_pairs=pairs)

    def frames(self, x: Array) -> Array:
        """Return the bodies' poses at a state, shape (bodies, 12)."""
        return self.model.frames(x)

    def placement(self, x: Array) -> tuple[Array, Array]:
        """Return the bodies' poses, shape (bodies, 12), and the cables' ends, (cables, 2, 3)."""
        return self.model.frames(x), self.model.cables(x) if self.cables else NO_ENDS

    def goal_errors(self, x: Array) -> Array:
        """Return the errors of all goal targets at a state, as ``Goal.errors``, shape (errors,)."""
        return self.goal.errors(x, self._goal_frames(x))

    def goal_residual(self, x: Array) -> Array:
        """Return the goal errors in tolerances, smooth in x, as ``Goal.residual``."""
        return self.goal.residual(x, self._goal_frames(x))

    def goal_excess(self, x: Array) -> float:
        """Return the goal violation of a state in tolerances: at most 1 inside."""
        return self.goal.excess(x, self._goal_frames(x))

    @property
    def asks(self) -> bool:
        """Whether the goal asks for something."""
        goal = self.goal
        return bool(goal.indices or goal.of_bodies or goal.parts or goal.predicate)

    def require_goal(self) -> None:
        """Require that the goal asks for something.

        Raises:
            InputError: If every state is in it.
        """
        if not self.asks:
            what, remedy = "nothing says where it shall go.", "Write x = 1.0 below it, for example."
            raise InputError([Mistake(f"{self._file} [goal]", what, remedy)])

    def goal_distance(self, x: Array) -> float:
        """Return the norm of all goal errors in SI units."""
        return self.goal.distance(x, self._goal_frames(x))

    def rests(self, x: Array) -> bool:
        """Say whether the velocities and auxiliary states of a state, shape (nx,), vanish."""
        nq = self.model.nq
        # of an entry's scale: what is slower rests
        return bool(np.abs(x[nq:] / self.scales[nq:]).max(initial=0.0) <= 1e-10)

    def _goal_frames(self, x: Array) -> Array | None:
        return self.frames(x) if self.goal.asks_frames else None

    def limit_violations(self, x: Array) -> Iterator[tuple[str, float, float, float]]:
        """Yield (name, value, lower, upper) of every limit that a state violates."""
        named = [(self.model.state_names, x, self.bounds)]
        if np.isfinite(self.rate_bounds).any():
            named.append((self.model.rate_names, self.model.velocity(x), self.rate_bounds))
        for names, values, bounds in named:
            for name, value, (lower, upper) in zip(names, values, bounds, strict=True):
                if not lower - LIMIT_TOLERANCE <= value <= upper + LIMIT_TOLERANCE:
                    yield name, float(value), float(lower), float(upper)
        yield from self.outside_world(self.frames(x))

    def outside_limits(self, x: Array) -> NDArray[np.bool_]:
        """Return which of several states (m, nx) have ``limit_violations``, shape (m,)."""
        outside = np.zeros(len(x), dtype=bool)
        for values, (lower, upper) in self._limited(x):
            within = (values >= lower - LIMIT_TOLERANCE) & (values <= upper + LIMIT_TOLERANCE)
            outside |= np.logical_not(within).any(axis=1)  # NaN is outside
        return outside

    def limit_excess(self, x: Array) -> Array:
        """Return by how much states (m, nx) pass each limit, shape (m, limits): negative inside.

        Each in its own unit, and minus infinity where there is no limit.
        """
        limited = self._limited(x)
        return np.hstack([np.maximum(v - upper, lower - v) for v, (lower, upper) in limited])

    def _limited(self, x: Array) -> Iterator[tuple[Array, Array]]:
        """Yield what is limited at states (m, nx): values (m, n) and their limits (2, n)."""
        yield x, self.bounds.T
        if np.isfinite(self.rate_bounds).any():
            yield self.model.velocity(x), self.rate_bounds.T
        if self.world.bounds or self.keep_outs:
            frames = self.model.frames(x)
            for axis, limits in self.world.bounds.items():
                place = frames[:, self.moving, "xyz".index(axis) * 4 + 3]
                yield place, np.array([limits]).T
            for cone in self.keep_outs:
                yield cone.angle(frames)[:, None], np.array([[cone.half_angle], [np.inf]])

    def outside_world(self, frames: Array) -> Iterator[tuple[str, float, float, float]]:
        """Yield violations of workspace and keep-out cones: (name, value, lower, upper).

        Args:
            frames: Poses of the bodies, shape (bodies, 12).
        """
        for cone in self.keep_outs:
            angle = float(cone.angle(frames))
            if not angle >= cone.half_angle - LIMIT_TOLERANCE:
                yield f"the axis of {self.bodies[cone.body].name}", angle, cone.half_angle, np.pi
        for axis, (lower, upper) in self.world.bounds.items():
            least, most = lower - LIMIT_TOLERANCE, upper + LIMIT_TOLERANCE
            place = frames[:, "xyz".index(axis) * 4 + 3].tolist()
            for body, value in zip(self.bodies, place, strict=True):
                if body.moves and not least <= value <= most:
                    yield f"{axis} of {body.name}", value, lower, upper

    def pose_margins(self, frames: Array) -> Array:
        """Return signed margins to workspace limits and keep-out cones: negative when violated.

        Smooth in the poses, for planners, which keep every limit without tolerance.

        Args:
            frames: Poses of the bodies, shape (m, bodies, 12).

        Returns:
            Shape (m, margins): distances in [m] of each body that moves from both limits of an
            axis, axis by axis, then differences of the cosines of each cone.
        """
        axes = ["xyz".index(axis) * 4 + 3 for axis in self.world.bounds]
        limits = np.array(list(self.world.bounds.values())).reshape(-1, 2, 1)
        place = frames[:, self.moving][:, :, axes].transpose(0, 2, 1)
        margins = np.stack([place - limits[:, 0], limits[:, 1] - place], axis=2)
        margins = margins.reshape(len(frames), -1)
        if not self.keep_outs:
            return margins
        cosines = [
            np.cos(cone.half_angle) - cone.in_world(frames) @ np.asarray(cone.direction)
            for cone in self.keep_outs
        ]
        return np.column_stack([margins, *cosines])

    def check_endpoints(self) -> None:
        """Raise if the start violates a constraint, or it or every goal a limit, or collides.

        Raises:
            EndpointError: Naming the constraints, the limits, and the pairs that collide.
        """
        mistakes = [
            *self.start_breaches(),
            *(Mistake(self._place("start"), what) for what in self._faults(self.start).values()),
            *self._goal_mistakes(),
        ]
        if mistakes:
            raise EndpointError(mistakes)

    def start_breaches(self) -> Iterator[Mistake]:
        """Yield the constraints that the start violates, with the nearest consistent state."""
        broken = constraint_violations(self.model, self.start)
        if broken:
            sizes = ", ".join(f"{one.name!r} by {one.size:.3g} {one.unit}" for one in broken)
            near = nearest_consistent_state(self.model, self.start, self.bounds)
            remedy = "Move it to where they hold; no such state was found nearby."
            if near is not None:
                remedy = f"The nearest start that holds has {self._changed_entries(near)}."
            yield Mistake(self._place("start"), f"it breaks {sizes}.", remedy)

    def _changed_entries(self, near: Array) -> str:
        """Print the entries that differ from the start's, with enough digits to be consistent."""
        near = np.where(np.abs(near) < SAME, 0.0, near)
        short = np.array([float(f"{value:.12g}") for value in near.tolist()])
        values = near if constraint_violations(self.model, short) else short
        differs = np.abs(values - self.start) > SAME
        names, spheres = self.model.state_names, self.model.space.spheres
        changed: dict[int, str | None] = {
            i: f"{names[i]} = {float(values[i])}" for i in np.flatnonzero(differs).tolist()
        }
        for part in spheres:
            if differs[part.own].any():
                changed |= dict.fromkeys(part.entries)
                changed[part.first] = f"{part.name} = {values[part.own].tolist()}"
        return ", ".join(text for _, text in sorted(changed.items()) if text)

    def _place(self, section: str) -> str:
        """Name the start or the goal, of which several machines have one each."""
        several = self.scenario.origin.machines
        return f"{self._file} {f'[[machine]] {section}' if several else f'[{section}]'}"

    @property
    def _file(self) -> str:
        return self.scenario.origin.file.name

    def _faults(self, x: Array) -> dict[str, str]:
        """Return what is wrong with a state: a sentence for each limit, requirement and pair."""
        return {
            name: f"{name} is {value:g}, outside {lower:g} to {upper:g}."
            for name, value, lower, upper in self.limit_violations(x)
        } | dict([*self._unmet(x), *self._touching(x)])

    def _touching(self, x: Array) -> Iterator[tuple[str, str]]:
        obstacles = {obstacle.name: obstacle.remedy for obstacle in self.world.obstacles}
        resting = {body.name for body in self.bodies if body.touches_ground}
        kinds = {body.name: [shape.lowered()[0] for shape in body.shapes] for body in self.bodies}
        round_ones = {name for name, own in kinds.items() if ShapeKind.CYLINDER in own}
        floor = ' If that is its floor, write ground = "plane" below [world].'
        wheel, large = " A body that stands on it has touches_ground=True.", ""
        system = self.scenario.system
        if str(system.file).endswith(ROBOT_FORMATS):  # where nobody can write it
            wheel = " Lift it in [start] and [goal], or leave ground out of [world]."
            large = "" if system.convex_parts else LARGE_SOLIDS
        for contact in self.checker().contacts(*self.placement(x)):
            stands = contact.body in resting and contact.obstacle in obstacles
            remedy = floor if stands and not self.world.ground else large
            if contact.kind == "sinks":
                remedy = LEANING if contact.body in round_ones else ""
            elif contact.obstacle == GROUND_NAME:
                remedy = wheel
            machines = self.scenario.origin.machines
            owners = [member_of(name, machines) for name in (contact.body, contact.obstacle)]
            if owners[0] != owners[1] and all(owners):
                remedy = f" Move [[machine]] {owners[0]} or {owners[1]} away from the other."
            told = _contact_sentence(contact, remedy) + obstacles.get(contact.obstacle, "")
            yield told, told

    def _unmet(self, x: Array) -> Iterator[tuple[str, str]]:
        """Name the requirements that no input can satisfy at a state."""
        margins = self.model.requirements(x).tolist()
        for requirement, margin in zip(self.machine.requirements, margins, strict=True):
            if not (requirement.needs_inputs or margin >= -LIMIT_TOLERANCE):
                name = f"a requirement ({requirement.name})"
                yield name, f"it breaks {name} by {-margin:g}."

    def _goal_mistakes(self) -> Iterator[Mistake]:
        where = self._place("goal")
        outside = list(self._goal_limits())
        if outside:
            yield from (Mistake(where, what) for what in outside)
            return
        generator, reasons, looked = np.random.default_rng(0), dict[str, list[str]](), 0
        for _ in range(200):  # samples of the goal region, checked before it is reported as blocked
            x = self.sample_goal(generator)
            if self.goal.needs_frames and not self.goal_excess(x) <= 1.0:
                continue  # what a state beside the goal touches says nothing about it
            faults, looked = self._faults(x), looked + 1
            if not faults:
                return
            for kind, fault in faults.items():
                reasons.setdefault(kind, []).append(fault)
        if not reasons:
            yield from self._out_of_reach(generator)
            return
        often = sorted(reasons.values(), key=len, reverse=True)
        always = [faults[0] for faults in often if len(faults) == looked]
        mostly = [f"in {len(faults)}, {faults[0]}" for faults in often[:2]]
        what = f"none of {looked} states in the goal region is free: "
        yield Mistake(where, what + " ".join(always[:1] or mostly))

    def _out_of_reach(self, generator: np.random.Generator) -> Iterator[Mistake]:
        """Name the point or the axis that no configuration brings to its target, if that is sure.

        Machines with closed loops are left out: nothing leads their samples to the goal.
        """
        if self.machine.closes_loops:
            return
        placed, tolerances = len(self.goal.of_bodies), self.goal.error_tolerances
        tolerances = tolerances[-placed:]

        def missed(x: Array) -> Array:
            return self.goal_errors(x)[-placed:]

        # states, each led as near as it comes, before a goal is called out of reach
        states = self.sample_goals(generator, np.ones(500))
        best = min(states, key=lambda x: float((missed(x) / tolerances).max()))
        nearest = missed(self.with_bodies_placed(best[None])[0])  # now for the very middle
        k = int(np.argmax(nearest / tolerances))
        miss, allowed, target = float(nearest[k]), float(tolerances[k]), self.goal.of_bodies[k]
        if miss <= MISSED_TOLERANCES * allowed or miss <= allowed + MISSED_LENGTH:
            return
        name, points = self.bodies[target.body].name, len(self.goal.points)
        if target in self.goal.formulas:
            path: tuple[str | int, ...] = ("goal", "region", k - placed + len(self.goal.formulas))
            told, unit = f"has {name}", ""
        elif isinstance(target, PointTarget):
            path = ("goal", "point", k)
            told, unit = f"brings the point of {name} to [{_listed(target.position)}]", "m"
        else:
            path = ("goal", "direction", k - points)
            told, unit = f"points the axis of {name} along [{_listed(target.target)}]", "rad"
        what = (
            f"no configuration was found that {told}: the closest misses by about "
            f"{miss:.2g} {unit}, and the tolerance is {allowed:.3g} {unit}."
        )
        remedy = "Move the target to where the machine can reach, or look at its limits."
        yield Mistake(place_at(path, self.scenario.origin), what, remedy)

    def _goal_limits(self) -> Iterator[str]:
        """Yield the state entries whose goal interval lies outside their limits."""
        goal = self.goal
        rows = zip(goal.indices, goal.targets.tolist(), goal.tolerances.tolist(), strict=True)
        for i, value, reach in rows:
            lower, upper = self.bounds[i].tolist()
            if not lower - LIMIT_TOLERANCE - reach <= value <= upper + LIMIT_TOLERANCE + reach:
                yield f"{self.model.state_names[i]} is {value:g}, outside {lower:g} to {upper:g}."

    def sample(self, generator: np.random.Generator) -> Array:
        """Sample a state uniformly within ``sampling_bounds``, attitudes uniformly on SO(3)."""
        x: Array = np.asarray(generator.uniform(*self.sampling_bounds.T))
        for part in self.model.space.spheres:
            x[part.own] = part.random(generator)
        return x

    def sample_goal(self, generator: np.random.Generator, spread: float = 1.0) -> Array:
        """Sample a state within the goal's tolerances, free entries uniformly within their limits.

        Where the goal places points or axes of bodies, the nearest configuration that does it is
        taken; where there is none, one that comes near. Collisions are not looked at.

        Args:
            spread: Factor on the tolerances.
        """
        return np.asarray(self.sample_goals(generator, np.array([spread]))[0])

    def sample_goals(self, generator: np.random.Generator, spreads: Array) -> Array:
        """Sample one state for each factor on the tolerances (n,), shape (n, nx).

        Vectorized, as ``sample_goal`` does. Targets beyond a limit are moved to it.
        """
        count = len(spreads)
        x = _uniform(generator, self.sampling_bounds.T, (count, self.model.nx))
        for part in self.model.space.spheres:
            x[:, part.own] = part.random(generator, count)
        goal, entries = self.goal, list(self.goal.indices)
        targets = len(entries) + len(goal.parts) + len(goal.points)
        shares = np.tile(spreads, (targets, 1)).T
        if goal.together:
            near_the_centre = _with_a_sum if goal.norm == "sum" else _in_a_ball
            shares *= near_the_centre(shares.shape, generator)
        reaches = np.abs(shares[:, len(entries) :]).T
        for fraction, one in zip(reaches, goal.parts, strict=False):
            angles = np.minimum(fraction * one.tolerance, np.pi)
            x[:, one.part.own] = one.part.near(np.array(one.target), angles, generator)
        # Column by column, which takes a third of the time that rows of few entries do.
        reach = np.asfortranarray(spreads[:, None] * goal.tolerances)
        lower, upper = self.bounds[entries].T if entries else np.zeros((2, 0))
        limits = lower - LIMIT_TOLERANCE, upper + LIMIT_TOLERANCE
        box = [np.clip(goal.targets + side * reach, *limits) for side in (-1.0, 1.0)]
        if goal.together:
            near = goal.targets + shares[:, : len(entries)] * goal.tolerances
            x[:, entries] = np.clip(near, *box)
        else:
            x[:, entries] = _uniform(generator, box, (count, len(entries)))
        return self.with_bodies_placed(x, self._offsets(shares, generator))

    def _offsets(self, shares: Array, generator: np.random.Generator) -> Array:
        """Sample offsets of the goal's points within the last shares (n, targets) of tolerances."""
        points = self.goal.points
        offsets = np.zeros((len(shares), len(points), 3))
        for k, point in enumerate(points):
            reaches = np.abs(shares[:, k - len(points)]) * point.tolerance
            offsets[:, k] = reaches[:, None] * _in_a_ball((len(shares), 3), generator)
        return offsets

    def with_bodies_placed(self, x: Array, offsets: Array | None = None) -> Array:
        """Return states with points and axes of bodies where the goal wants them, or near that.

        What the goal states of entries and attitudes stays. Attitudes that turn freely come first,
        for which there is a closed form. Machines with closed loops stay as they are otherwise.

        Args:
            x: States, shape (n, nx).
            offsets: Of the points from their targets in [m], shape (n, points, 3); none: 0.
        """
        goal = self.goal
        x = pointed(self.model, goal, x)
        if not goal.needs_frames or self.machine.closes_loops:
            return x
        if offsets is None:
            offsets = np.zeros((len(x), len(goal.points), 3))
        scales, limits = self.model.state_scales, self.bounds
        return reaching(self.model, goal, x, offsets, scales=scales, limits=limits)

    @cached_property
    def space(self) -> StateSpace:
        """The machine's state space; angles limited by the scenario do not wrap."""
        return self.model.space.limited(self.circular)

    @cached_property
    def sampling_bounds(self) -> Array:
        """Finite limits of each state entry, shape (nx, 2); a full turn for circular ones."""
        bounds = self.bounds.copy()
        bounds[self.circular] = -np.pi, np.pi
        for part in self.model.space.spheres:
            bounds[part.own] = -1.0, 1.0
        if self.cost_entry is not None:
            bounds[self.cost_entry] = 0.0  # which is nowhere compared
        for clock in self.model.clocks:
            bounds[clock, 1] = min(bounds[clock, 1], self.start[clock] + HORIZON)
        return bounds


def _listed(numbers: tuple[float, ...]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)


def _contact_sentence(contact: Any, remedy: str) -> str:
    phrase = {
        "touches": f"{contact.body} {contact.verb} {contact.obstacle}.{remedy}",
        "inside": f"{contact.body} {contact.verb} {contact.obstacle}.",
        "sinks": f"{contact.body} {contact.verb} {contact.obstacle}.{remedy}",
        "near": f"{contact.body} is nearer to {contact.obstacle} than [world] clearance allows.",
    }
    return phrase.get(contact.kind, f"the pose of {contact.body} cannot be judged.")


def _uniform(
    generator: np.random.Generator, bounds: Iterable[Array], shape: tuple[int, int]
) -> Array:
    """Draw what ``generator.uniform`` draws within bounds that are arrays, three times as fast."""
    lower, upper = bounds
    return np.asarray(lower + (upper - lower) * generator.random(shape))


def _with_a_sum(shape: tuple[int, int], generator: np.random.Generator) -> Array:
    """Sample points (n, d) uniformly in the unit ball of the 1-norm.

    Source: Devroye, Non-Uniform Random Variate Generation, 1986, section V.2.1.
    """
    parts = generator.exponential(size=(shape[0], shape[1] + 1))
    signs = generator.choice([-1.0, 1.0], size=shape)
    points: Array = signs * parts[:, :-1] / parts.sum(axis=1, keepdims=True)
    return points


def _in_a_ball(shape: tuple[int, int], generator: np.random.Generator) -> Array:
    """Sample points (n, d) uniformly in the Euclidean unit ball."""
    paths, d = generator.normal(size=shape), max(shape[1], 1)
    lengths = np.maximum(np.linalg.norm(paths, axis=1, keepdims=True), 1e-300)
    points: Array = generator.uniform(size=(shape[0], 1)) ** (1 / d) * paths / lengths
    return points
