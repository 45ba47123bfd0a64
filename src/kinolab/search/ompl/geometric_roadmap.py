"""OMPL's PRM over the configuration space of a machine at rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from kinolab.concurrency.cancel import raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.ompl.configuration_space import ConfigurationSpace, PathValidator
from kinolab.search.ompl.control_search import ompl_seed

MIN_EDGE_LENGTH = 1e-12  # SciPy treats length zero as no edge


class GeometricRoadmap:
    """OMPL's probabilistic roadmap between a start and a goal.

    OMPL checks for solutions in a second thread while its roadmap grows, so equal seeds would give
    different paths. Here it only grows: start and goal are inserted by a query that ends at once,
    and the shortest path is computed on its graph.

    Args:
        configurations: The configuration space.
        start: Start state, shape (nx,).
        goal: Goal state, shape (nx,).
        seed: OMPL's random seed.
        neighbours: Maximum number of neighbours that a configuration is connected to.
    """

    def __init__(
        self,
        configurations: ConfigurationSpace,
        start: Array,
        goal: Array,
        seed: int,
        neighbours: int,
    ) -> None:
        self._configurations = configurations
        information = ob.SpaceInformation(configurations.space)
        information.setStateValidityChecker(configurations.is_valid)
        information.setMotionValidator(PathValidator(information, configurations))
        information.setup()
        definition = ob.ProblemDefinition(information)
        begin, end = configurations.space.allocState(), configurations.space.allocState()
        configurations.write(begin, start)
        configurations.write(end, goal)
        definition.setStartAndGoalStates(begin, end)
        ou.RNG.setSeed(ompl_seed(seed))
        self._information, self._planner = information, og.PRM(information)
        self._planner.setMaxNearestNeighbors(neighbours)
        self._planner.setProblemDefinition(definition)
        self._planner.setup()
        self._planner.solve(ob.timedPlannerTerminationCondition(0.0))

    @property
    def size(self) -> int:
        """Number of configurations in the roadmap."""
        return int(self._planner.milestoneCount())

    def grow(self, count: int, budget: Budget) -> None:
        """Add ``count`` configurations, or fewer if the budget runs out."""
        end = self.size + count
        condition = ob.PlannerTerminationCondition(lambda: self.size >= end or budget.spent())
        self._planner.growRoadmapPtc(condition)

    def path(self) -> list[Array] | None:
        """Return the shortest path from start to goal, states (nx,) at rest; None if there is none.

        Raises:
            CancelledError: If the search is cancelled.
        """
        graph = _Graph(self._information, self._planner, self._configurations)
        return (graph.path_to(graph.goal) or None) if graph.goal in graph.reached else None

    def approach(self, distance: Callable[[Array], float]) -> list[Array]:
        """Return the path to the reachable configuration nearest to the goal, states (nx,) at rest.

        Args:
            distance: Distance of a state from the goal.

        Raises:
            CancelledError: If the search is cancelled.
        """
        graph = _Graph(self._information, self._planner, self._configurations)
        apart = dict[int, float]()
        for k in graph.reached:
            raise_if_cancelled(self._configurations.stop)
            x = graph.configuration(k)
            apart |= {} if x is None else {k: distance(x)}
        return graph.path_to(min(apart, key=lambda k: apart[k])) if apart else []


class _Graph:
    """Snapshot of OMPL's roadmap; it must not outlive its planner.

    Args:
        information: OMPL's space information.
        planner: OMPL's planner.
        configurations: The configuration space; cancelling it raises a CancelledError.

    Attributes:
        reached: Vertices that can be reached from the start.
        goal: Vertex of the goal; -1 if it is not part of the roadmap.
    """

    def __init__(self, information: Any, planner: Any, configurations: ConfigurationSpace) -> None:
        self._data, self._configurations = ob.PlannerData(information), configurations
        planner.getPlannerData(self._data)
        size, state = self._data.numVertices(), self._state
        self._begin = self._data.getStartIndex(0) if self._data.numStartVertices() else -1
        self.goal = self._data.getGoalIndex(0) if self._data.numGoalVertices() else -1
        edges, lengths = list[tuple[int, int]](), list[float]()
        for a in range(size):
            raise_if_cancelled(configurations.stop)
            new = [(a, b) for b in self._data.getEdges(a)]
            lengths += [information.distance(state(a), state(b)) for _, b in new]
            edges += new
        self.reached: list[int] = []
        if self._begin < 0:
            return
        rows = np.array(edges, dtype=np.int64).reshape(-1, 2).T
        table = scipy.sparse.csr_array(
            (np.maximum(lengths, MIN_EDGE_LENGTH), tuple(rows)), (size, size)
        )
        found, self._before = scipy.sparse.csgraph.dijkstra(
            table, directed=False, indices=self._begin, return_predecessors=True
        )
        self.reached = np.flatnonzero(np.isfinite(found)).tolist()

    def _state(self, vertex: int) -> Any:
        return self._data.getVertex(vertex).getState()

    def configuration(self, vertex: int) -> Array | None:
        """Return the equilibrium (nx,) of a vertex; None if there is none."""
        return self._configurations.read(self._state(vertex))

    def path_to(self, vertex: int) -> list[Array]:
        """Return the states (nx,) of the shortest path from the start to a reachable vertex."""
        path = [vertex]
        while path[-1] != self._begin:
            path.append(int(self._before[path[-1]]))
        states = map(self.configuration, reversed(path))
        return [x for x in states if x is not None]
