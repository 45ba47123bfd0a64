"""Velocities that determine all others at every configuration within a machine's limits.

Of a body on a knife edge, x_dot and theta_dot do not: with the edge along y, x_dot is zero however
fast the body slides. There, velocities of frames along their own axes are taken instead, as V.x of
the frame whose V.y is zero.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, section 3.8; Siciliano et al., Robotics:
Modelling, Planning and Control, 2009, section 11.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb
from typing import Any

import numpy as np

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.derivation.sampled_states import sampled_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.language.frames import Frame, velocity
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.numerics.arrays import Array

MIN_PIVOT = 1e-6  # smallest singular value of a usable choice, relative to the rows' norm
MAX_CHOICES = 5000  # above which the choice is greedy instead of optimal
SAME = 1e-9  # rounding of a direction


@dataclass(frozen=True)
class VelocityChoice:
    """Which velocities are states.

    Attributes:
        dependent: Indices of the rates that are none.
        quasi: The quasi-velocities among them, which come first.
    """

    dependent: tuple[int, ...]
    quasi: tuple[QuasiVelocity, ...] = ()


@dataclass(frozen=True)
class _Candidate:
    velocity: QuasiVelocity
    axis: str
    body: str
    covector: tuple[Node, ...]
    values: Array


def regular_choice(
    binding: SymbolTable,
    rows: Sequence[Sequence[Node]],
    free: Sequence[int],
    rates: Sequence[int],
) -> VelocityChoice:
    """Choose quasi-velocities where rates are singular somewhere, and nothing where none is better.

    Args:
        rows: Coefficients of all velocities in each condition, (m, nt).
        free: Indices of the velocities that may follow from others.
        rates: Indices of those that follow if only rates are chosen.
    """
    places, chosen = SampledConstraints.of(binding), VelocityChoice(tuple(rates))
    regular = places.singular(rows, rates) is None
    return chosen if regular else _quasi(rows, places, free, rates) or chosen


def singular_configuration(
    binding: SymbolTable, rows: Sequence[Sequence[Node]], dependent: Sequence[int]
) -> dict[str, float] | None:
    """Return coordinates, by name, at which a choice of velocities does not determine the motion.

    None where none was found within the coordinates' limits, or where loops are closed.

    Args:
        rows: Coefficients of all velocities in each condition, quasi-velocities included.
        dependent: Indices of the velocities that follow from them.
    """
    if not rows or binding.system.closures:
        return None
    found = SampledConstraints.of(binding).singular(rows, dependent)
    if found is None:
        return None
    return {name: found[name] for name in binding.names(binding.configuration)}


@dataclass(frozen=True)
class SampledConstraints:
    """Configurations within a machine's limits, and what else its constraints rest on.

    The velocities nu follow from A nu = b: the determinant of A's columns of dependent velocities
    must not vanish. Configurations within the limits form a connected set where no loop is closed,
    so a determinant of both signs vanishes in between.

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
        rows = list(sampled_values(binding, 256))  # at which determinants are compared
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

        labels = self.binding.names(self.binding.configuration)
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


def _quasi(
    rows: Sequence[Sequence[Node]],
    places: SampledConstraints,
    free: Sequence[int],
    rates: Sequence[int],
) -> VelocityChoice | None:
    """Choose as few quasi-velocities as make the choice regular; None where none is better."""
    held = places.covectors(rows)
    usable = np.isfinite(held).all(axis=(1, 2))
    places = replace(places, values=places.values[usable])
    held = held[usable]
    directions = list(_directions(places, held))
    # 0.3, by which the mean logarithm of a determinant must grow
    best, merit = None, _merit(held, rates) + 0.3
    for count in range(1, held.shape[2] - held.shape[1] + 1):
        for chosen, dependent in _ranked(held, free, directions, count):
            whole = np.concatenate([held, *(c.values for c in chosen)], axis=1)
            made = VelocityChoice(dependent, _labelled(places.binding, chosen))
            if places.singular([*rows, *(c.covector for c in chosen)], dependent) is None:
                return made
            if _merit(whole, dependent) > merit:
                best, merit = made, _merit(whole, dependent)
    return best


def _ranked(
    held: Array, free: Sequence[int], directions: Sequence[_Candidate], count: int
) -> list[tuple[tuple[_Candidate, ...], tuple[int, ...]]]:
    """Return choices of ``count`` quasi-velocities, the most even one first.

    A determinant that is the same everywhere, as of a tractor's speed and turn rate, makes short
    equations; among those, the best conditioning counts.
    """
    found: list[Any] = []  # choices, each after what it is ordered by
    size = held.shape[1] + count
    if size > len(free) or comb(len(free), size) * comb(len(directions), count) > MAX_CHOICES:
        return []
    for chosen in combinations(directions, count):
        whole = np.concatenate([held, *(entry.values for entry in chosen)], axis=1)
        for dependent in combinations(free, size):
            sizes = np.abs(np.linalg.det(whole[:, :, list(dependent)]))
            evenness = float(sizes.min() / max(sizes.max(), 1e-300))
            margin = float(margins_of(whole, dependent).min())
            order = round(evenness, 3), round(margin, 6), -len(found)
            found.append((order, chosen, dependent))
    found.sort(key=lambda entry: entry[0], reverse=True)
    # 40 choices with quasi-velocities that are examined for singular configurations
    return [(chosen, dependent) for _, chosen, dependent in found[:40]]


def _merit(covectors: Array, dependent: Sequence[int]) -> float:
    """Return the mean logarithm of a choice's determinant: how far from singular it is."""
    sizes = np.abs(normalised_determinants(covectors, dependent))
    return float(np.mean(np.log(np.maximum(sizes, 1e-300))))


def _directions(places: SampledConstraints, held: Array) -> Iterator[_Candidate]:
    """Yield velocities of frames along their axes, except rates and what constraints hold."""
    system, nt = places.binding.system, held.shape[2]
    known: list[Array] = [np.broadcast_to(row, (len(held), nt)) for row in np.eye(nt)]
    known += [held[:, k] for k in range(held.shape[1])]
    for body, frame in _frames(system):
        V = velocity(frame)
        for axis, component in zip("xyz", (V.x, V.y, V.z), strict=True):
            covector = places.binding.slopes(component)[1]
            values = places.covectors([covector])
            if not np.isfinite(values).all() or any(_parallel(values[:, 0], row) for row in known):
                continue
            known.append(values[:, 0])
            speed, scale = _sizes(system, values[:, 0])
            direction = f"velocity of the frame of {body} along its {axis} axis"
            made = QuasiVelocity(
                f"V_{axis}", component, speed=speed, scale=scale, direction=direction
            )
            yield _Candidate(made, axis, body, covector, values)


def _frames(system: Mechanism) -> Iterator[tuple[str, Frame]]:
    """Yield the frames of bodies, then those that they are placed in, with a body's name."""
    seen = set()
    frames = [(body.name, body.frame.motions) for body in system.bodies]
    for cut in range(max((len(motions) for _, motions in frames), default=0)):
        for body, motions in frames:
            part = motions[: len(motions) - cut]
            if part and part not in seen:
                seen.add(part)
                yield body, Frame(part)


def _parallel(a: Array, b: Array) -> bool:
    """Whether two covectors are parallel, or the first one zero, at every configuration."""
    along = np.einsum("ij,ij->i", a, b)
    sizes = np.einsum("ij,ij->i", a, a) * np.einsum("ij,ij->i", b, b)
    return bool(np.all(sizes - along**2 <= SAME * np.maximum(sizes, SAME)))


def _sizes(system: Mechanism, covectors: Array) -> tuple[float, float]:
    """Return the largest magnitude that the rates' limits allow, and a characteristic one."""
    owners = [c for c in system.coordinates for _ in c.rates]
    weights = np.abs(covectors)
    used = weights.max(axis=0) > SAME
    speeds = np.array([c.speed for c in owners])[used]
    scales = np.array([c.scale for c in owners])[used]
    speed = float((weights[:, used] @ speeds).max()) if np.isfinite(speeds).all() else math.inf
    return _rounded_up(speed), _rounded_up(float((weights[:, used] * scales).max()))


def _rounded_up(value: float) -> float:
    """Round a size up to three digits: it is the largest of samples."""
    if not math.isfinite(value):
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{math.ceil(value / unit * (1 - SAME)) * unit:.3g}")


def _labelled(binding: SymbolTable, chosen: Sequence[_Candidate]) -> tuple[QuasiVelocity, ...]:
    """Name quasi-velocities by axis, and by body where one axis occurs twice or a name is taken."""
    axes = [entry.axis for entry in chosen]
    system, taken = binding.system, set(binding.names(binding.tangent))
    taken |= {c.name for c in system.coordinates} | {p.name for p in system.parameters}
    taken |= {entry.name for entry in system.inputs} | {entry.name for entry in system.states}
    named = []
    for entry in chosen:
        name = f"V_{entry.axis}"
        if axes.count(entry.axis) > 1 or name in taken:
            name = f"{name}_{entry.body}".replace(" ", "_").replace("-", "_")
        while name in taken:
            name += "_"
        taken.add(name)
        named.append(replace(entry.velocity, name=name))
    return tuple(named)


def margins_of(covectors: Array, dependent: Sequence[int]) -> Array:
    """Return the smallest singular values relative to the rows' norms, shape (samples,).

    Args:
        covectors: Rows of coefficients, shape (samples, n, nt).
        dependent: Indices of the n velocities that follow from them.
    """
    sizes = np.linalg.norm(covectors, axis=(1, 2), ord=2)
    smallest = np.linalg.svd(covectors[:, :, list(dependent)], compute_uv=False)[:, -1]
    shares: Array = smallest / np.maximum(sizes, 1e-300)
    return shares


def left_open(covectors: Array, dependent: Sequence[int]) -> list[int]:
    """Return those dependent velocities that a choice leaves open at most states; mostly none.

    Args:
        covectors: Rows of coefficients, shape (samples, n, nt).
        dependent: Indices of the n velocities that are to follow from them.
    """
    if np.median(margins_of(covectors, dependent)) >= MIN_PIVOT:
        return []
    free = np.abs(np.linalg.svd(covectors[:, :, list(dependent)])[2][:, -1]).mean(axis=0)
    return [i for i, size in zip(dependent, free, strict=True) if size > free.max() / 2]
