"""Whether a choice of independent velocities determines all velocities at every configuration.

The velocities nu follow from A nu = b. The determinant of A's columns of dependent velocities must
not vanish. Configurations within the limits form a connected set where no loop is closed, so a
determinant of both signs vanishes in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.derivation.symbol_table import SymbolTable, sampled_values
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class SampledConstraints:
    """Configurations within a machine's limits, and what else its constraints rest on.

    Attributes:
        names: Of all symbols of the machine.
        values: Theirs, shape (configurations, names).
        limits: Lower and upper limit of what may vary; equal for what may not.
    """

    binding: SymbolTable
    names: tuple[str, ...]
    values: Array
    limits: Array

    @classmethod
    def of(cls, binding: SymbolTable) -> SampledConstraints:
        """Sample configurations; the same machine always gives the same ones."""
        rows = list(sampled_values(binding.system, 256))  # at which determinants are compared
        names = tuple(rows[0])
        values = np.array([[row[name] for name in names] for row in rows])
        limits = np.stack([values.min(axis=0), values.max(axis=0)], axis=1)
        places = {c.name: c for c in binding.system.coordinates if isinstance(c, Coordinate)}
        for k, name in enumerate(names):
            c = places.get(name)
            if c is None:
                limits[k] = -np.inf, np.inf
            elif np.isfinite([c.lower, c.upper]).all():
                limits[k] = c.lower, c.upper
        return cls(binding, names, values, limits)

    def covectors(self, rows: Sequence[Sequence[Node]], values: Array | None = None) -> Array:
        """Evaluate rows of coefficients at configurations; shape (configurations, rows, nt)."""
        table = self.values if values is None else values
        formulas = Formulas.of(self.binding.tape, [entry for row in rows for entry in row])
        with np.errstate(all="ignore"):
            flat = formulas(dict(zip(self.names, table.T, strict=True)))
        columns = [np.broadcast_to(entry, len(table)) for entry in flat]
        return np.reshape(np.stack(columns, axis=1), (len(table), len(rows), -1))

    def determinants(
        self,
        rows: Sequence[Sequence[Node]],
        dependent: Sequence[int],
        values: Array | None = None,
    ) -> Array:
        """Return determinants relative to Hadamard's bound, between -1 and 1, shape (m,)."""
        return normalised_determinants(self.covectors(rows, values), dependent)

    def singular(
        self, rows: Sequence[Sequence[Node]], dependent: Sequence[int]
    ) -> dict[str, float] | None:
        """Return a configuration at which rows do not determine the dependent velocities.

        None where no such configuration was found within the limits.
        """
        sizes = self.determinants(rows, dependent)
        usable = np.flatnonzero(np.isfinite(sizes))
        if not usable.size:
            return None
        sizes = sizes[usable]
        found = self.values[usable]
        least, most = int(np.argmin(sizes)), int(np.argmax(sizes))
        if sizes[least] < 0 < sizes[most]:
            return self._named(self._between(rows, dependent, found[least], found[most]))
        order = np.argsort(np.abs(sizes))
        # 0.5: smallest over median of a determinant that has no dips to look into
        if abs(sizes[order[0]]) > 0.5 * np.median(np.abs(sizes)):
            return None
        for k in order[:4]:  # smallest determinants from which a minimum is sought
            dip = self._dip(rows, dependent, found[k])
            # 1e-4 of a determinant over the product of its rows' norms
            if abs(self.determinants(rows, dependent, dip[None])[0]) < 1e-4:
                return self._named(dip)
        return None

    def _between(
        self, rows: Sequence[Sequence[Node]], dependent: Sequence[int], a: Array, b: Array
    ) -> Array:
        """Bisect between configurations whose determinants have opposite signs, a's negative."""
        for _ in range(60):
            middle = (a + b) / 2
            if self.determinants(rows, dependent, middle[None])[0] < 0:
                a = middle
            else:
                b = middle
        return b

    def _dip(self, rows: Sequence[Sequence[Node]], dependent: Sequence[int], start: Array) -> Array:
        """Minimise the size of a determinant within the limits."""
        from scipy.optimize import minimize

        labels = {self.binding.tape.operations[q].label for q in self.binding.configuration}
        moving = [k for k, name in enumerate(self.names) if name in labels]

        def size(z: Array) -> float:
            here = start.copy()
            here[moving] = z
            value = float(self.determinants(rows, dependent, here[None])[0])
            return value**2 if np.isfinite(value) else 1.0

        best = minimize(size, start[moving], bounds=self.limits[moving], method="L-BFGS-B")
        place = start.copy()
        place[moving] = best.x
        return place

    def _named(self, values: Array) -> dict[str, float]:
        return dict(zip(self.names, map(float, values), strict=True))


def normalised_determinants(covectors: Array, dependent: Sequence[int]) -> Array:
    """Return determinants of the dependent columns, relative to the product of the rows' norms.

    Args:
        covectors: Rows of coefficients, shape (m, rows, nt).
        dependent: Indices of as many columns as there are rows.

    Returns:
        Shape (m,), between -1 and 1.
    """
    norms = np.linalg.norm(covectors, axis=2)
    with np.errstate(all="ignore"):
        scaled = covectors / np.maximum(norms, 1e-300)[:, :, None]
        found: Array = np.linalg.det(scaled[:, :, list(dependent)])
    return found
