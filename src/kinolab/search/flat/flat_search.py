"""One search in flat outputs: what it works on, and what it does one after the other."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numba import typeof

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.neighbours.r_tree import r_tree
from kinolab.numerics.rng import State, generator
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.problem.goal_kernel import GoalArrays, goal_arrays
from kinolab.search.flat.car_drives import DRIVE_PIECES, CarWork
from kinolab.search.flat.car_routes import measure_car
from kinolab.search.flat.flat_following import follow_pieces
from kinolab.search.flat.flat_machine import (
    CAR,
    PLANE,
    FlatMachine,
    flat_machine,
    refusal,
    tightened,
)
from kinolab.search.flat.flat_pieces import Pieces, copy_pieces
from kinolab.search.flat.flat_routes import gather_corners, prune_corners, put_route
from kinolab.search.flat.flat_shortcuts import shorten_pieces
from kinolab.search.flat.flat_trees import (
    NONE,
    FlatTree,
    begin_trees,
    grow_trees,
    nearest_node,
)
from kinolab.search.graph import SearchGraph
from kinolab.simulation.collision_context import (
    CollisionContext,
    CollisionScratch,
    collision_context,
)
from kinolab.simulation.limits import LimitArrays, limit_arrays
from kinolab.simulation.machine import Machine, machine_of
from kinolab.simulation.propagator import FREE, StepChecks, check_state
from kinolab.steering.path_motion import MAX_STEPS

GOALS, NEAREST = 16, 4  # places in the goal that are drawn, and from which a tree grows
WITHIN = 0.99  # of the range of a coordinate, whose limits a motion that is followed may not pass
MAX_PIECES = 256  # of a motion, three for each of its lines
CANNOT_STEER = "it cannot steer where it stands, or drive along its tightest curves."


class GoalHolder(NamedTuple):
    """The goal, as ``goal_violation`` looks for it."""

    goal: GoalArrays


class FlatWork(NamedTuple):
    """Scratch memory."""

    x: Annotated[Array, "nx"]
    ahead: Annotated[Array, "nx"]
    slopes: Annotated[Array, "nu"]
    u: Annotated[Array, "nu"]
    held: Annotated[Array, "nu"]
    rates: Annotated[Array, 2, "nx"]
    gain: Annotated[Array, "nu", "nu"]
    pivots: Annotated[Integers, "nu"]
    change: Annotated[Array, "nu"]
    z: Annotated[Array, "axes"]
    direction: Annotated[Array, "axes"]
    around: Annotated[Array, "axes"]
    begin: Annotated[Array, "axes"]
    end: Annotated[Array, "axes"]
    last: Annotated[Array, "axes"]
    point: Annotated[Array, "outputs"]
    sample: Annotated[Array, "outputs"]
    knots: Annotated[Array, 3, "outputs", 3]
    drive: Annotated[Array, 2, 2]
    pose: Annotated[Array, 3]


class FlatSearch(NamedTuple):
    """All that one search works on, for compiled kernels."""

    machine: Machine
    flat: FlatMachine
    limits: LimitArrays
    tight: LimitArrays  # without what is left to corrections
    collision: CollisionContext
    scratch: CollisionScratch
    problem: GoalHolder
    random: State
    step: float  # in [s]
    reach: float  # of an extension, in the metric
    heads: bool  # whether the goal asks for a heading
    begin: Array  # (nx,) the start
    start: Array  # (axes,) its outputs, and a heading
    goals: Array  # (places, axes) in the goal
    ahead: FlatTree  # from the start
    behind: FlatTree  # from the goal
    work: FlatWork
    car: CarWork
    trial: Pieces  # which are looked at
    draft: Pieces  # a motion
    spare: Pieces  # scratch
    known: Pieces  # the draft as it was before the last shortcuts
    corners: Annotated[Array, "corners", "outputs"]
    u: Annotated[Array, "step capacity", "nu"]
    states: Annotated[Array, "state capacity", "nx"]
    turn: Annotated[Integers, 1]  # iterations of the trees
    links: Annotated[Integers, 2]  # the nodes at which they meet
    counts: Annotated[Integers, 1]  # clearances that were asked for


def flat_search(problem: PlanningTask, seed: int, reach: float, max_nodes: int) -> FlatSearch:
    """Collect what a search works on.

    Args:
        reach: Longest extension, as a fraction of the diagonal of the space of outputs.

    Raises:
        InputError: If the machine is none that can be planned for in flat outputs.
    """
    flat, model = flat_machine(problem), problem.model
    axes, outputs = len(flat.entry), len(flat.lower)
    sizes = {"nx": model.nx, "nu": model.nu, "axes": axes, "outputs": outputs}
    sizes |= {"capacity": max_nodes, "corners": 1024, "step capacity": MAX_STEPS}
    sizes |= {"state capacity": MAX_STEPS + 1}
    limits, random = limit_arrays(problem), generator(seed)
    context = collision_context(problem)
    machine = machine_of(problem)
    places = _places(problem, flat, seed, StepChecks(machine, limits, *context))
    tight = _tightened(problem, flat, limits, places)
    own = flat.entry[:outputs]
    flat = flat._replace(
        lower=np.maximum(flat.lower, tight.lower[own]),
        upper=np.minimum(flat.upper, tight.upper[own]),
    )
    period = np.where(np.isfinite(flat.period), flat.period * flat.weight, np.inf)
    ways = np.minimum((flat.upper - flat.lower) * flat.weight, period / 2)

    def tree() -> FlatTree:
        return allocate(FlatTree, sizes, neighbours=r_tree(max_nodes, period))

    def pieces(count: int) -> Pieces:
        return allocate(Pieces, sizes | {"pieces": count})

    return allocate(
        FlatSearch,
        sizes,
        machine=machine,
        flat=flat,
        limits=limits,
        tight=tight,
        collision=context[0],
        scratch=context[1],
        problem=GoalHolder(goal_arrays(problem.goal)),
        random=random,
        step=problem.step,
        reach=reach * float(np.linalg.norm(ways)),
        heads=flat.kind == PLANE and int(flat.entry[2]) in problem.goal.entries,
        begin=np.clip(problem.start, *problem.bounds.T),
        start=np.ascontiguousarray(problem.start[flat.entry]),
        goals=places,
        ahead=tree(),
        behind=tree(),
        trial=pieces(DRIVE_PIECES),
        draft=pieces(MAX_PIECES),
        spare=pieces(MAX_PIECES + DRIVE_PIECES + 1),
        known=pieces(MAX_PIECES),
    )


def _tightened(
    problem: PlanningTask, flat: FlatMachine, limits: LimitArrays, places: Array
) -> LimitArrays:
    """Return the limits that motions keep before they are followed: they end at some places."""
    bounds = problem.bounds.copy()
    bounds[flat.speeds] = tightened(bounds[flat.speeds])
    inner = tightened(bounds[flat.entry], WITHIN)
    ends = np.vstack([problem.start[flat.entry], places])
    lower, upper = inner.T
    bounds[flat.entry, 0] = np.where(lower <= ends.min(axis=0), lower, bounds[flat.entry, 0])
    bounds[flat.entry, 1] = np.where(upper >= ends.max(axis=0), upper, bounds[flat.entry, 1])
    rates = tightened(np.stack([limits.rate_lower, limits.rate_upper], axis=1))
    return limits._replace(
        lower=np.ascontiguousarray(bounds[:, 0]),
        upper=np.ascontiguousarray(bounds[:, 1]),
        rate_lower=np.ascontiguousarray(rates[:, 0]),
        rate_upper=np.ascontiguousarray(rates[:, 1]),
    )


def _places(problem: PlanningTask, flat: FlatMachine, seed: int, checks: StepChecks) -> Array:
    """Return places of rest in the goal where nothing is touched, shape (places, axes).

    Those at a limit are left out where there are others, and so are those that are far away.
    """
    random, record, inside = np.random.default_rng(seed), Record(checks), list[Array]()
    for _ in range(10):  # draws, until one of them is free
        # of the goal's tolerance, in which they are; the rest is for what is off at the end
        x = problem.sample_goals(random, 0.5 * random.uniform(size=GOALS))
        x[:, flat.speeds] = 0.0
        free = [row for row in x if check_state(record, row)[0] == FREE]
        inside += [row for row in free if problem.goal_excess(row) <= 1.0]
        if inside:
            break
    places = np.array(inside).reshape(-1, problem.model.nx)[:, flat.entry]
    lower, upper = tightened(problem.bounds[flat.entry], WITHIN).T
    well = ((places >= lower) & (places <= upper)).all(axis=1)
    places = places[well] if well.any() else places
    ways = (places - problem.start[flat.entry])[:, : len(flat.lower)]
    ways = np.where(np.isfinite(flat.period), wrapped(ways), ways) * flat.weight
    order = np.argsort(np.linalg.norm(ways, axis=1), kind="stable")
    return np.ascontiguousarray(places[order[:NEAREST]])


class FlatConnection:
    """Grows trees, makes motions of what they find, and shortens these.

    Args:
        problem, seed, reach, max_nodes: As ``flat_search`` takes them.

    Attributes:
        u: Inputs of the best motion, shape (N, nu); None before there is one.
    """

    def __init__(self, problem: PlanningTask, seed: int, reach: float, max_nodes: int) -> None:
        self._problem = problem  # whose model owns the compiled code
        self._own = flat_search(problem, seed, reach, max_nodes)
        self._search = Record(self._own)
        self._draft, self._known = Record(self._own.draft), Record(self._own.known)
        self._ahead = Record(self._own.ahead)
        self.u: Array | None = None
        self.has_goals = len(self._own.goals) > 0

    def prepare(self) -> None:
        """Compile or load all loops, and begin.

        Raises:
            InputError: If it is a car whose inputs do not let it steer and drive.
        """
        if self._own.flat.kind == CAR and not measure_car(self._search):
            raise refusal(self._problem, CANNOT_STEER)
        self.begin()
        self.grow(0)
        gather_corners(self._search, 0, NONE)
        put_route(self._search, prune_corners(self._search, 1), NONE)
        nearest_node(self._search, self._ahead, self._own.start[: self._own.corners.shape[1]])
        copy_pieces(self._known, self._draft)
        self.shorten(0)

    def compile_for_cars(self) -> None:
        """Compile the loops that cars alone need, whatever the machine is."""
        measure_car.compile((typeof(self._search),))

    def begin(self) -> None:
        """Begin with trees that have their roots only."""
        begin_trees(self._search)

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow both trees; return GROWING, LINKED or FILLED, and the iterations made."""
        ended, made = grow_trees(self._search, iterations)
        return int(ended), int(made)

    def connect(self) -> bool:
        """Make a motion of linked trees, which is the draft then; say whether there is one."""
        node, other = self._own.links.tolist()
        count, root = gather_corners(self._search, node, other)
        if count < 2 or not put_route(self._search, prune_corners(self._search, count), root):
            return False
        copy_pieces(self._draft, self._known)
        return True

    def shorten(self, attempts: int) -> bool:
        """Try shortcuts of the draft, and follow it; say whether it leads into the goal.

        If it does not, it is again what it was before.
        """
        shorten_pieces(self._search, attempts)
        steps, refused = follow_pieces(self._search, self._draft, True)
        if refused or not self._problem.goal_excess(self._own.states[steps]) <= 1.0:
            copy_pieces(self._known, self._draft)
            return False
        copy_pieces(self._draft, self._known)
        if self.u is None or steps < len(self.u):
            self.u = self._own.u[:steps].copy()
        return True

    def approach(self) -> Array:
        """Return inputs (N, nu) to the place nearest to the goal that the first tree has."""
        own, nothing = self._own, np.zeros((0, self._problem.model.nu))
        if not self.has_goals:
            return nothing
        node = int(nearest_node(self._search, self._ahead, own.goals[0, : own.corners.shape[1]]))
        count, _ = gather_corners(self._search, node, NONE)
        if count < 2 or not put_route(self._search, prune_corners(self._search, count), NONE):
            return nothing
        steps, _ = follow_pieces(self._search, self._draft, False)
        return own.u[:steps].copy()

    @property
    def states(self) -> Array:
        """States of rest that the first tree has, shape (n, nx)."""
        return self._states(self._own.ahead)

    @property
    def graph(self) -> SearchGraph:
        """Both trees."""
        ahead, behind = self._own.ahead, self._own.behind
        x = np.concatenate([self._states(ahead), self._states(behind)])
        parents = ahead.parent[: ahead.size[0]], behind.parent[: behind.size[0]]
        later = np.where(parents[1] < 0, NONE, parents[1] + ahead.size[0])
        return SearchGraph.of_tree(lambda rows: x[rows], np.concatenate([parents[0], later]))

    def _states(self, tree: FlatTree) -> Array:
        z = tree.z[: int(tree.size[0])]
        x = np.tile(self._own.flat.base, (len(z), 1))
        x[:, self._own.flat.entry[: z.shape[1]]] = z
        return x

    @property
    def nodes(self) -> int:
        """Of both trees."""
        return int(self._own.ahead.size[0] + self._own.behind.size[0])

    @property
    def clearances(self) -> int:
        """That were asked for along lines and shortcuts."""
        return int(self._own.counts[0])
