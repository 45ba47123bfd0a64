"""Controllability of a machine at its equilibria."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from kinolab.dynamics import (
    LinearControllability,
    Model,
    SmallTimeVerdict,
    System,
    VectorFields,
    linear_controllability,
    small_time_controllability,
)
from kinolab.dynamics.analysis.equilibrium import equilibrium
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class AtRest:
    """Controllability at an equilibrium.

    Attributes:
        state: The state, by name.
        held: The equilibrium inputs, by name.
        linear: Controllability of the linearisation about it.
        small_time: Small-time local controllability; None if inputs do not enter linearly.
        upright: Names of the entries that are 1 at the identity attitude.
    """

    state: dict[str, float]
    held: dict[str, float]
    linear: LinearControllability
    small_time: SmallTimeVerdict | None
    upright: frozenset[str] = frozenset()

    def says_the_same(self, other: AtRest) -> bool:
        """Whether what holds near this equilibrium holds near another one."""
        first, second = self.small_time, other.small_time
        alike = (first and first.outcome) == (second and second.outcome)
        return alike and self.linear.rank == other.linear.rank


def examined_at_rest(system: System, fields: VectorFields, left_out: list[str]) -> Iterator[AtRest]:
    """Yield controllability near the rest position, and near another if it differs there.

    A rest position is often a special one: a stretched arm, wheels that are straight.

    Args:
        left_out: Receives sentences about what could not be determined.
    """
    model = system.model().plant  # a controller may not allow rest; the plant does
    elsewhere = [_place(model, fields, point) for point in fields.points]
    found = held_state(model, [model.rest(), *elsewhere])
    if found is None:
        left_out.append("controllability at rest: no state was found in which inputs can hold it.")
        return
    if fields.prolonged:
        left_out.append("controllability in small time: an input does not enter linearly.")
    first = _examined(model, fields, *found)
    yield first
    if (place := held_state(model, elsewhere)) is not None:
        other = _examined(model, fields, *place)
        if not other.says_the_same(first):
            yield other


def held_state(model: Model, starts: Iterable[Array]) -> tuple[Array, Array] | None:
    """Return an equilibrium state and its inputs, or None.

    Args:
        starts: Initial guesses, each of shape (nx,); the first that converges within limits counts.

    Returns:
        x of shape (nx,) and u of shape (nu,), within the limits of the inputs.
    """
    lower, upper = model.control_bounds.T
    for start in starts:
        found = equilibrium(model, start, polish=True)
        if found is not None:
            u = found[1]
            # 1e-9: allowed violation of an input limit
            if (lower - 1e-9 <= u).all() and (u <= upper + 1e-9).all():
                return found
    return None


def _examined(model: Model, fields: VectorFields, x: Array, u: Array) -> AtRest:
    state = dict(zip(model.state_names, map(float, x), strict=True))
    held = dict(zip(model.control_names, map(float, u), strict=True))
    limits = {entry.name: bounds_of(entry) for entry in model.system.inputs}
    return AtRest(
        state=state,
        held=held,
        linear=linear_controllability(model, x, u),
        small_time=None
        if fields.prolonged
        else small_time_controllability(fields, state, held, limits=limits),
        upright=frozenset(model.state_names[part.pole] for part in model.space.spheres),
    )


def _place(model: Model, fields: VectorFields, point: Mapping[str, float]) -> Array:
    """Return a sampled state, rounded; entries absent from the equations stay at rest."""
    nodes = [node for parts in fields.components.values() for node in parts]
    occurring = frozenset[int]().union(*(fields.tape.depends_on(node) for node in nodes))
    matters = {n for n, node in zip(fields.names, fields.state, strict=True) if node in occurring}
    x = model.rest()
    for k, name in enumerate(model.state_names):
        if name in matters:
            x[k] = round(point[name], 1)
    return x
