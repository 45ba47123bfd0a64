"""Regions as Syclop asks for them.

OMPL 2.0.1's wheel hands ``project`` a copy of the coordinates that it is to fill, so that what
Python writes there is lost, and OMPL goes on with zeros. The bounds of the grid are shared, though:
``project`` moves the grid under the zeros instead of the coordinates over the grid. The finer grid
by which OMPL measures coverage has bounds of its own, out of reach. To it all states look alike,
and a region counts as covered as soon as one state lies in it.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.ompl.syclop.regions import Regions

# states that OMPL draws to estimate free volumes; the wheel cannot change it
FREE_VOLUME_DRAWS = 100_000


class Decomposition(oc.GridDecomposition):  # type: ignore[misc]
    """A grid of regions that leads go through.

    A planner keeps it, so that it must not refer to the planner. It serves one planner once: OMPL
    asks first where the states lie that it estimates free volumes from, and these questions are
    counted. Most are answered by "outside", for looking at all of them would take seconds.

    Args:
        setup: The problem in OMPL's terms.
        regions: That there are.
        looks: States that free volumes are estimated from.
        max_states_per_cell: How many states a cell of the default projection may hold; leads pass
            by all further ones.
        seed: Of the states that are drawn.
    """

    def __init__(
        self, setup: OmplSetup, regions: Regions, *, looks: int, max_states_per_cell: int, seed: int
    ) -> None:
        bounds = ob.RealVectorBounds(len(regions.low))
        bounds.low, bounds.high = regions.low, regions.high
        super().__init__(regions.cells, len(regions.low), bounds)
        self._keep_regions()
        self._problem, self._states, self._guide = setup.problem, setup.states, setup.guide
        self._regions, self._generator = regions, np.random.default_rng(seed)
        empty = list(regions.empty())
        self._aside = empty[0] if empty else None
        self._assumed = self._assume(empty, looks)
        self._every = (
            max(1, (FREE_VOLUME_DRAWS - len(self._assumed)) // looks)
            if looks
            else FREE_VOLUME_DRAWS + 1
        )
        self._asked, self._outside = 0, False
        self._projection, self._held = setup.projection, Counter[tuple[int, ...]]()
        self._most = max_states_per_cell
        self._last: tuple[list[float], list[float]] = ([], [])

    def project(self, state: Any, _: list[float]) -> None:
        """Move the grid so that zero lies in it where the state's coordinates would."""
        self._asked += 1
        if self._asked <= len(self._assumed):
            values, coordinates = self._assumed[self._asked - 1]
            self._states.write(state, values)
            self._move_under(coordinates)
        elif self._asked > FREE_VOLUME_DRAWS or self._asked % self._every == 0:
            self._move_under(self._place(self._states.read(state)))
            self._outside = False
        elif not self._outside:
            self._move([1.0] * len(self._regions.low), [2.0] * len(self._regions.low))
            self._outside = True

    def sampleFullState(self, sampler: Any, coordinates: list[float], state: Any) -> None:
        """Write a state of the region that the coordinates were drawn from."""
        *position, level = coordinates
        if level >= 1.0:
            spread = self._regions.reach(int(level))
            near = self._problem.sample_goal(self._generator, spread)
            self._states.write(state, near.tolist())
            return
        sampler.sampleUniform(state)
        values = self._states.read(state)
        for entry, value in zip(self._regions.entries, position, strict=True):
            values[entry] = value
        self._states.write(state, values)

    def _assume(self, empty: list[list[float]], looks: int) -> list[tuple[list[float], Any]]:
        """List states with coordinates that OMPL shall look at before any that it has drawn.

        It raises the share of a region that is free to the eighth power, which few looks do not
        bear: as many free states are assumed as there are looks. In regions without states one is
        assumed that is not free.
        """
        start = np.clip(self._problem.start, *self._problem.bounds.T).tolist()
        far = list(self._regions.far())
        often = max(1, looks // len(far)) if looks else 0
        beyond = self._beyond(start)
        return [*[(start, middle) for middle in far] * often, *((beyond, at) for at in empty)]

    def _beyond(self, values: list[float]) -> list[float]:
        """Return a state like another that breaks a limit, as long as there is any."""
        low, high = self._problem.bounds.T
        for k in np.flatnonzero(np.isfinite(high - low) & ~self._problem.circular):
            return [*values[:k], float(2 * high[k] - low[k] + 1.0), *values[k + 1 :]]
        return values

    def _place(self, values: list[float]) -> list[float]:
        """Return the coordinates of a state.

        What an obstacle or a limit stopped is put where no lead leads, for few ways lead on from
        it, and so is what ends where many have ended.
        """
        if self._guide is None or self._aside is None or not self._guide.ended_in(values):
            return self._regions.coordinates(values)
        if values != self._last[0]:  # OMPL asks more than once
            aside = self._guide.stopped(values) or self._crowds(values)
            self._last = values, self._aside if aside else self._regions.coordinates(values)
        return self._last[1]

    def _crowds(self, values: list[float]) -> bool:
        """Count a state in its cell, and say whether that held enough already."""
        cell = self._projection.cell(values)
        self._held[cell] += 1
        return self._held[cell] > self._most

    def _keep_regions(self) -> None:
        """Let OMPL work out the bounds of all regions, which it keeps, before the grid moves."""
        generator, unused = ou.RNG(), [0.0] * self.getDimension()
        for region in range(self.getNumRegions()):
            self.sampleFromRegion(region, generator, unused)

    def _move_under(self, coordinates: list[float]) -> None:
        """Move the grid so that zero lies in it where coordinates would, or at its nearest edge."""
        low, high = self._regions.low, self._regions.high
        rows = zip(coordinates, low, high, strict=True)
        at = [min(max(value, lowest), highest) for value, lowest, highest in rows]
        self._move(
            [lowest - value for lowest, value in zip(low, at, strict=True)],
            [highest - value for highest, value in zip(high, at, strict=True)],
        )

    def _move(self, low: list[float], high: list[float]) -> None:
        bounds = self.getBounds()  # not kept: it refers to this object, unseen by the collector
        bounds.low, bounds.high = low, high
