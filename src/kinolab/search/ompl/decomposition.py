"""Grid decomposition for Syclop.

OMPL 2.0.1's wheel passes ``project`` a copy of the coordinates to fill, so what Python writes there
is lost and OMPL continues with zeros. But the bounds of the grid are shared: ``project`` shifts the
grid instead of the coordinates. The finer grid by which OMPL measures coverage has bounds of its
own that cannot be changed. To it all states look alike, and a region counts as covered as soon as
it contains one state.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from kinolab.search.ompl.regions import Regions
from kinolab.search.ompl.simple_setup import OmplSetup

# samples of OMPL's free-volume estimate, fixed in the wheel
FREE_VOLUME_DRAWS = 100_000


class Decomposition(oc.GridDecomposition):  # type: ignore[misc]
    """The grid of regions that guides a search.

    A planner keeps it, so it must not refer to the planner. It serves one planner once: OMPL first
    projects the samples of its free-volume estimate, and these calls are counted. Most samples are
    reported as outside the grid, since checking all of them would take seconds.

    Args:
        samples: Number of samples of the free-volume estimate.
        max_states_per_cell: Capacity of a cell of the default projection; the guide ignores further
            states.
    """

    def __init__(
        self,
        setup: OmplSetup,
        regions: Regions,
        *,
        samples: int,
        max_states_per_cell: int,
        seed: int,
    ) -> None:
        bounds = ob.RealVectorBounds(len(regions.low))
        bounds.low, bounds.high = regions.low, regions.high
        super().__init__(regions.cells, len(regions.low), bounds)
        generator, unused = ou.RNG(), [0.0] * self.getDimension()
        for region in range(self.getNumRegions()):  # OMPL keeps their bounds before the grid shifts
            self.sampleFromRegion(region, generator, unused)
        self._problem, self._states, self._guide = setup.problem, setup.states, setup.guide
        self._regions, self._generator = regions, np.random.default_rng(seed)
        empty = list(regions.empty())
        self._aside = empty[0] if empty else None
        self._assumed = self._assume(empty, samples)
        self._every = (
            max(1, (FREE_VOLUME_DRAWS - len(self._assumed)) // samples)
            if samples
            else FREE_VOLUME_DRAWS + 1
        )
        self._asked, self._outside = 0, False
        self._projection, self._held = setup.projection, Counter[tuple[int, ...]]()
        self._most = max_states_per_cell
        self._last: tuple[list[float], list[float]] = ([], [])

    def project(self, state: Any, _: list[float]) -> None:
        """Shift the grid so that zero lies in the state's region."""
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
        """Sample a state in the region from which the coordinates were drawn."""
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

    def _assume(self, empty: list[list[float]], samples: int) -> list[tuple[list[float], Any]]:
        """List prior states with coordinates, to replace the first samples that OMPL draws.

        OMPL raises the free fraction of a region to the eighth power, which is too noisy for few
        samples: as many free states are assumed as samples are taken. In regions without states
        an invalid one is assumed.
        """
        start = np.clip(self._problem.start, *self._problem.bounds.T).tolist()
        far = list(self._regions.far())
        often = max(1, samples // len(far)) if samples else 0
        beyond = self._beyond(start)
        return [*[(start, middle) for middle in far] * often, *((beyond, at) for at in empty)]

    def _beyond(self, values: list[float]) -> list[float]:
        """Return a copy of a state that violates a limit, if there is any limit."""
        low, high = self._problem.sampling_bounds.T
        for k in np.flatnonzero(np.isfinite(high - low) & ~self._problem.circular):
            return [*values[:k], float(2 * high[k] - low[k] + 1.0), *values[k + 1 :]]
        return values

    def _place(self, values: list[float]) -> list[float]:
        """Return the coordinates of a state.

        States stopped by an obstacle or a limit are hard to extend; they are put into a region that
        no lead visits, and so are states in crowded cells.
        """
        if self._guide is None or self._aside is None or not self._guide.ended_in(values):
            return self._regions.coordinates(values)
        if values != self._last[0]:  # OMPL asks more than once
            aside = self._guide.stopped(values)
            if not aside:
                cell = self._projection.cell(values)
                self._held[cell] += 1
                aside = self._held[cell] > self._most
            self._last = values, self._aside if aside else self._regions.coordinates(values)
        return self._last[1]

    def _move_under(self, coordinates: list[float]) -> None:
        """Shift the grid so that zero lies at given coordinates, clamped to the grid."""
        low, high = self._regions.low, self._regions.high
        rows = zip(coordinates, low, high, strict=True)
        at = [min(max(value, lowest), highest) for value, lowest, highest in rows]
        self._move(
            [lowest - value for lowest, value in zip(low, at, strict=True)],
            [highest - value for highest, value in zip(high, at, strict=True)],
        )

    def _move(self, low: list[float], high: list[float]) -> None:
        bounds = self.getBounds()  # not kept: a reference cycle invisible to the collector
        bounds.low, bounds.high = low, high
