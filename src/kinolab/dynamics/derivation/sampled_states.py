"""States at which a machine is looked at to decide something once: the same ones each time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.numerics.manifolds.state_parts import spheres_of


def feasible_values(binding: SymbolTable) -> Iterator[dict[str, float]]:
    """Yield sampled values of all symbols, projected onto the position constraints."""
    gaps = [binding.lower(constraint.position) for constraint in binding.system.closures]
    slopes = [node for gap in gaps for node in gradient(binding, gap)]
    for values in sampled_values(binding):
        try:
            if _close(binding, gaps, slopes, values):
                yield values
        except (ArithmeticError, ValueError):
            continue


# More than 12 never changed a choice.
def sampled_values(binding: SymbolTable, count: int = 12) -> Iterator[dict[str, float]]:
    """Yield values of all symbols by name: the rest position first, then random ones in limits."""
    generator, system = np.random.default_rng(0), binding.system
    names, spheres = _entries(binding), spheres_of(binding.parts)
    for k in range(count):
        values = dict(system.parameter_values)
        for coordinate in system.coordinates:
            if isinstance(coordinate, Coordinate):
                value = random_value(coordinate, generator)
                values[coordinate.name] = value if k else rest_value(coordinate)
                values[f"{coordinate.name}_dot"] = float(generator.normal())
            else:
                values |= {s.name: float(generator.normal()) for s in coordinate.entries}
                values |= {s.name: float(generator.normal()) for s in coordinate.rates}
        for part in spheres:
            own = names[part.own]
            length = float(np.linalg.norm([values[name] for name in own]))
            values |= {name: values[name] / length if length else 0.0 for name in own}
            values[own[-1]] += 0.0 if length else 1.0
        values |= {entry.name: float(generator.normal()) for entry in system.states}
        values |= {entry.name: float(generator.normal()) for entry in system.inputs}
        yield values


def rest_value(coordinate: Coordinate) -> float:
    """Return a coordinate's default start: 0, or the limit nearest to it."""
    return min(max(0.0, coordinate.lower), coordinate.upper)


def random_value(coordinate: Coordinate, generator: np.random.Generator) -> float:
    """Sample a coordinate: anywhere on a circle, within its limits on a line."""
    if coordinate.topology == "circle":
        return float(generator.uniform(-np.pi, np.pi))
    lower, upper = coordinate.lower, coordinate.upper
    if not np.isfinite(lower):
        lower = (upper if np.isfinite(upper) else coordinate.scale) - 2 * coordinate.scale
    if not np.isfinite(upper):
        upper = lower + 2 * coordinate.scale
    return float(generator.uniform(lower, upper))


def _entries(binding: SymbolTable) -> list[str]:
    """Return the names of the entries of the configuration."""
    return [entry.name for c in binding.system.coordinates for entry in c.entries]


def gradient(binding: SymbolTable, node: Node) -> list[Node]:
    """Return the derivatives of a node by the entries of the configuration."""
    tape = binding.tape
    return [tape.derivative([node], {q: tape.one})[0] for q in binding.configuration]


def _close(
    binding: SymbolTable, gaps: Sequence[Node], slopes: Sequence[Node], values: dict[str, float]
) -> bool:
    """Project a configuration onto the constraints by least-norm Newton steps."""
    if not gaps:
        return True
    names = _entries(binding)
    for _ in range(50):  # towards a configuration that satisfies the loop closure
        gap = np.array(binding.tape.evaluate(gaps, values))
        if np.abs(gap).max() < 1e-10:  # [m] or [rad], of such a configuration
            return True
        matrix = np.reshape(binding.tape.evaluate(slopes, values), (len(gaps), len(names)))
        move = np.linalg.lstsq(matrix, gap, rcond=None)[0]
        for name, change in zip(names, move, strict=True):
            values[name] -= float(change)
    return False
