"""Description of a machine: structure, constraints and controllability."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from kinolab.analyze.describe.at_rest import AtRest, examined_at_rest
from kinolab.analyze.describe.conserved import (
    conserved_momenta,
    cyclic_coordinates_of,
    momenta_of,
)
from kinolab.analyze.describe.decoupling import Decoupling, decoupling_of
from kinolab.analyze.describe.generalisations import Generalisation, generalisations_of
from kinolab.analyze.describe.sizes import BodySize, body_sizes
from kinolab.analyze.describe.states import StateStorage, state_storage
from kinolab.analyze.describe.topology import dimension_of, space_of
from kinolab.dynamics import Model, System, VectorFields
from kinolab.dynamics.analysis.fields.growth_vectors import Filtration, filtration
from kinolab.dynamics.analysis.fields.involutive import InvolutiveClosure, involutive_closure
from kinolab.dynamics.analysis.fields.system_fields import vector_fields
from kinolab.dynamics.analysis.flatness_of import FlatnessFound, flatness_of
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.derivation.singularity import singularity_of
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import constraint_rows, independent_rows
from kinolab.dynamics.facts.machine_facts import MachineFacts
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.inputs import Input
from kinolab.errors import InputError


@dataclass(frozen=True)
class ConstraintKind:
    """A constraint and its classification.

    Attributes:
        name: Name of the constraint.
        kind: ``holonomic``, ``nonholonomic``, ``holonomic in disguise``, ``repeats others``, or
            ``depends on inputs``.
    """

    name: str
    kind: str


@dataclass(frozen=True)
class Description:
    """Structure and controllability of a machine.

    Attributes:
        name: Name of the machine.
        space: Its configuration space as a product.
        dimension: Of the configuration space.
        freedom: Degrees of freedom: independent velocities under the constraints.
        states: The state space: its dimension and what it consists of.
        velocities: The independent velocities and speeds that are states, each with what it is.
        singular: Where they do not determine the motion, in a sentence; empty if nowhere.
        constraints: Each with its kind.
        inputs: The control inputs.
        closure: Of the admissible motions; None if the constraints depend on inputs.
        accessible: Span of brackets of the equations of motion, without the drift itself.
        prolonged: Whether the inputs count as states there, because one does not enter linearly.
        pushes: Number of independent directions in which inputs act.
        potential: Whether the potential energy depends on the configuration.
        rests: Equilibria and their controllability: near the rest position, and near another one
            if it differs there.
        generalisations: Six generalisations of the upright rolling disk.
        left_out: What could not be determined, in sentences.
        bodies: Each with its mass and the extent of its shapes.
        machine: Its facts, of which coordinates, requirements and notes are shown.
        units: Of its parameters, by name.
        watched: Pairs of bodies or cables that may not touch each other, by name.
        cyclic: Coordinates on which the Lagrangian does not depend.
        conserved: Coordinates on which neither energies nor forces depend, without forces of their
            own: their momenta stay as they are.
        momenta: Those of all bodies together that no input changes, of a machine with an attitude.
        flat: What is known of its flatness; None where it has not been asked.
        decoupling: The directions that it can follow at any speed, of a machine whose inputs do not
            push along every velocity; None if the notion does not apply.
    """

    name: str
    space: str
    dimension: int
    freedom: int
    states: StateStorage
    velocities: tuple[tuple[str, str], ...]
    singular: str
    constraints: tuple[ConstraintKind, ...]
    inputs: tuple[Input, ...]
    closure: InvolutiveClosure | None
    accessible: Filtration
    prolonged: bool
    pushes: int
    potential: bool
    rests: tuple[AtRest, ...]
    generalisations: tuple[Generalisation, ...]
    left_out: tuple[str, ...]
    machine: MachineFacts
    units: Mapping[str, str]
    bodies: tuple[BodySize, ...] = ()
    watched: tuple[tuple[str, str], ...] = ()
    cyclic: tuple[str, ...] = ()
    conserved: tuple[str, ...] = ()
    momenta: tuple[str, ...] = ()
    flat: FlatnessFound | None = None
    decoupling: Decoupling | None = None


def describe(system: System, *, switching: Sequence[str] = ()) -> Description:
    """Describe a machine.

    Args:
        switching: Names of the transitions between the modes of which this is one.

    Raises:
        InputError: If its equations cannot be derived.
    """
    left_out: list[str] = []
    fields = vector_fields(system)
    closure = _closure(system, left_out)
    disguised = closure.disguised if closure else 0
    leaf = replace(fields, dimension=fields.dimension - disguised)
    accessible = filtration(leaf, strong=True)
    if not accessible.complete:
        what = f"brackets of more than {len(accessible.growth)} fields, which might span more"
        left_out.append(f"{what}, take too long.")
    rests = tuple(examined_at_rest(system, leaf, left_out))
    freedom = _freedom(system, closure)
    model = system.model().plant
    pushed = len(system.inputs) if fields.prolonged else next(iter(accessible.growth), 0)
    pushes, potential = min(pushed, freedom), _has_potential(model, fields)
    return Description(
        name=system.name,
        space=space_of(system),
        dimension=dimension_of(system),
        freedom=freedom,
        states=state_storage(
            system,
            dimension=fields.dimension - (len(system.inputs) if fields.prolonged else 0),
            stored=model.nx,
            redundant=model.redundant,
        ),
        velocities=(
            *((entry.name, entry.direction) for entry in model.quasi_velocities),
            *((model.rate_names[i], "rate of a coordinate") for i in model.independent),
        ),
        singular="" if (found := singularity_of(system)) is None else found.sentence,
        constraints=tuple(_kinds(system, closure)),
        inputs=system.inputs,
        closure=closure,
        accessible=accessible,
        prolonged=fields.prolonged,
        pushes=pushes,
        potential=potential,
        rests=rests,
        generalisations=generalisations_of(
            system, freedom=freedom, pushes=pushes, potential=potential, switching=switching
        ),
        left_out=tuple(left_out),
        machine=model.machine,
        units={parameter.name: parameter.unit for parameter in system.parameters},
        bodies=body_sizes(system),
        watched=system.collisions,
        cyclic=cyclic_coordinates_of(system),
        conserved=conserved_momenta(system),
        momenta=momenta_of(system),
        flat=flatness_of(system),
        decoupling=decoupling_of(system, closure.leaf) if closure and pushes < freedom else None,
    )


def _closure(system: System, left_out: list[str]) -> InvolutiveClosure | None:
    try:
        return involutive_closure(system)
    except InputError as error:
        left_out.append(f"which constraints can be integrated: {error}")
        return None


def _has_potential(model: Model, fields: VectorFields) -> bool:
    """Whether the potential energy differs between sampled configurations."""
    if is_kinematic(model.system):
        return False
    places = [[point[name] for name in model.state_names] for point in fields.points]
    energies = [model.energy(x)[1] for x in places]
    # 1e-9: rounding of a potential energy, relative to its largest value
    return bool(max(energies) - min(energies) > 1e-9 * max(map(abs, energies)))


def _freedom(system: System, closure: InvolutiveClosure | None) -> int:
    if closure is not None:
        return closure.growth[0] if closure.growth else 0
    binding = SymbolTable.of(system)
    kept, _ = independent_rows(binding, constraint_rows(binding))
    return dimension_of(system) - len(kept)


def _kinds(system: System, closure: InvolutiveClosure | None) -> Iterator[ConstraintKind]:
    for constraint in system.constraints:
        kind = "nonholonomic"
        if isinstance(constraint, PositionConstraint):
            kind = "holonomic"
        elif closure is None:
            kind = "depends on inputs"
        elif constraint.name in closure.integrable:
            kind = "holonomic in disguise"
        if closure is not None and constraint.name in closure.redundant:
            kind = "repeats others"
        yield ConstraintKind(constraint.name, kind)
