"""A compiled machine: equations of motion as functions of numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.arguments import require_fit
from kinolab.dynamics.codegen.cache import Compiled, key_of
from kinolab.dynamics.codegen.compiled_functions import CHATTERS, SINGULAR
from kinolab.dynamics.codegen.machine_code import MachineCode, bound
from kinolab.dynamics.codegen.mode_formulas import FORMULAS, ModeFormulas
from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.dynamics.facts.machine_facts import (
    CoordinateFacts,
    MachineFacts,
    QuasiVelocityFacts,
    facts_of,
)
from kinolab.errors import (
    InputError,
    Mistake,
    NoDynamicsError,
    SingularError,
    UnknownNameError,
    listed,
)
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import Rotations, completed, spheres_of
from kinolab.store import pickled

if TYPE_CHECKING:  # what describes and derives a machine: one that is in the cache needs none of it
    from kinolab.dynamics.lagrange.equations import Equations
    from kinolab.dynamics.language.feedback import Feedback
    from kinolab.dynamics.language.mechanism import Mechanism

POSE = 12  # numbers per body: the rows of [R | p]


class Described(NamedTuple):
    """What is known of a machine once it was described: enough to find its compiled code.

    Attributes:
        machine: Facts.
        key: Of the model.
        files: Texts of files that it comes from, by name.
    """

    machine: MachineFacts
    key: str
    files: dict[str, str]


DESCRIBED = pickled("described", Described)


class Model:
    """The equations of motion of a machine, compiled.

    A state x is (q, v, auxiliary states): the configuration with four numbers per attitude, the
    independent velocities, and what else has a rate. Angles are in rad and are not wrapped. Every
    method takes parameter values by keyword, which override the system's without compiling
    anything.

    Where the machine has feedback, the inputs u of every method are the references of its law, and
    ``plant`` is the machine without it; ``plant_inputs`` gives the plant's own inputs.

    Args:
        system: The machine; its feedback, if it has one, is a law.

    Raises:
        InputError: If the machine cannot be derived, or its regulator is still to be designed.

    Attributes:
        machine: What planning asks besides equations: names, limits, shapes.
        key: Stands for the machine, all of it, on this processor.
        independent: Indices, among all velocities, of those that are states.
        quasi_velocities: What else are independent velocities, before those; most machines have
            none.
        velocity_names: Names of the independent velocities, shape (nv,).
        redundant: Names of constraints that follow from the others.
        methods: Of integration, by name: those that there were when it was described.
        state_names: Names of the entries of x, shape (nx,).
        control_names: Names of the entries of u, shape (nu,).
        clocks: The entries of x that are the time; at rest they go on.
        rate_names: Names of all velocities, shape (nt,).
        control_bounds: Lower and upper limit of each input, shape (nu, 2).
        state_bounds: Lower and upper limit of each entry of x, shape (nx, 2).
        state_scales: What counts as a large difference in each entry of x, shape (nx,); a rate's
            is its speed limit, or its coordinate's scale per second.
        nx: Number of entries of a state.
        nu: Number of inputs.
        nq: Number of entries of a configuration.
        nv: Number of independent velocities.
        nt: Number of velocities, the dependent ones included.
        operations: Number of operations of the equations of motion, in the first mode.
        projects: Whether steps end on constraints of position and unit quaternions: see
            ``project``.
    """

    def __init__(self, system: Mechanism) -> None:
        from kinolab.dynamics.language.json.machine_file import machine_to_json
        from kinolab.dynamics.language.mechanism import Mechanism
        from kinolab.dynamics.language.mechanism_parts import primitives_in

        require_fit("Model system", Mechanism, system)
        _require_law(system)
        machine = facts_of(system)
        text = f"{machine_to_json(system)}{primitives_in(system)}"
        self._set(machine, key_of(text), lambda: system)
        self.system = system

    @classmethod
    def kept(cls, content: str, describe: Callable[[], Mechanism]) -> Model | None:
        """Return the model of a machine that is in the cache, None of one that is not.

        Args:
            content: All that determines the machine, as text.
            describe: Returns the machine, should its symbols be needed; can be pickled.
        """
        found = DESCRIBED.find([key_of(content)])
        if found is None:
            return None
        made = cls.__new__(cls)
        made._set(found.machine, found.key, describe)
        made.files, made._source = found.files, (content, describe)
        return made

    @classmethod
    def described_by(cls, content: str, describe: Callable[[], Mechanism]) -> Model:
        """Return the model of a machine, described only where it is not in the cache.

        Args:
            content: As ``kept``.
            describe: As ``kept``.

        Raises:
            InputError: As the constructor.
        """
        made = cls.kept(content, describe)
        if made is None:
            made = cls(describe())
            made.keep(content)
        return made

    def with_values(self, values: Mapping[str, float]) -> Model:
        """Return the same machine with other values of parameters, by the same code.

        Args:
            values: By the parameters' names; of those on which no size of a body depends.

        Raises:
            UnknownNameError: If a parameter does not exist.
        """
        made, formulas = copy(self), self.formulas
        for name in ("system", "files", "plant"):
            vars(made).pop(name, None)
        made._defaults = self.parameter_vector(**values)
        given = tuple(zip(self.parameter_names, made._defaults.tolist(), strict=True))
        made.machine = replace(self.machine, parameters=given)
        made.key = key_of(f"{self.key} {sorted(values.items())}")
        made.formulas, made._alike = formulas, (self, dict(values))
        made._describe = lambda: self.system.with_parameters(**values)
        return made

    def keep(self, content: str) -> None:
        """Let ``kept`` find this machine by a text."""
        DESCRIBED.keep([key_of(content)], Described(self.machine, self.key, self.files))

    def _set(self, machine: MachineFacts, key: str, describe: Callable[[], Mechanism]) -> None:
        """Set all attributes but ``system``."""

        def build() -> Compiled:
            from kinolab.dynamics.codegen.derived_code import derived_code

            described = describe()
            return derived_code(
                described,
                _require_law(described),
                lambda formulas: FORMULAS.keep([key], formulas),
            )

        self.machine, self.key, self._describe = machine, key, describe
        self._source: tuple[str, Callable[[], Mechanism]] | None = None
        self._alike: tuple[Model, dict[str, float]] | None = None  # whose code it has, and values
        self._code = MachineCode(
            key, build, closed=machine.references is not None, switches=bool(machine.modes)
        )
        self.independent, self.redundant = self._code.independent, self._code.redundant
        self.methods, self.operations = self._code.methods, self._code.operations
        self.projects = bool(self._code.sizes["project"])
        self.quasi_velocities = self._code.quasi
        self.coordinate_names = tuple(name for c in machine.coordinates for name in c.entries)
        self.rate_names = machine.rate_names
        self.velocity_names = (
            *(entry.name for entry in self.quasi_velocities),
            *(self.rate_names[i] for i in self.independent),
        )
        self.state_names = (
            *self.coordinate_names,
            *self.velocity_names,
            *(entry.name for entry in machine.states),
        )
        self.control_names = tuple(entry.name for entry in machine.chosen)
        self.nx, self.nu = len(self.state_names), len(self.control_names)
        self.nq, self.nv = len(self.coordinate_names), len(self.velocity_names)
        self.nt = len(self.rate_names)
        self.control_bounds: Array = np.array(
            [entry.limits for entry in machine.chosen], dtype=float
        ).reshape(-1, 2)
        self.state_bounds, self.state_scales = _entries(
            machine, self.quasi_velocities, self.independent
        )
        units = {entry: c.unit for c in machine.coordinates for entry in c.entries}
        self.clocks = [i for i, name in enumerate(self.coordinate_names) if units[name] == "s"]
        self._parts = completed(machine.parts, self.nx)
        self.parameter_names = tuple(name for name, _ in machine.parameters)
        self._defaults = np.array([value for _, value in machine.parameters])

    def __repr__(self) -> str:
        """Name the machine, its states and its inputs, on one line."""
        told = f"states {listed(self.state_names)}; inputs {listed(self.control_names) or 'none'}"
        return f"<Model {self.machine.name}: {told}>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel to another process as the machine: addresses of code are worth nothing there."""
        if self._alike is not None:
            return Model.with_values, self._alike
        if self._source is None:
            return Model, (self.system,)
        return Model.described_by, self._source

    @cached_property
    def files(self) -> dict[str, str]:
        """The machine as text, by the names of the files that ``load_machine`` reads."""
        from kinolab.dynamics.language.json.machine_file import files_of

        return files_of(self.system)

    @cached_property
    def formulas(self) -> tuple[ModeFormulas, ...]:
        """What boxes of states are enclosed by, of each mode; derived where it is not on the disk.

        Plans are verified again and again while they are improved, so it stays.
        """

        def made() -> tuple[ModeFormulas, ...]:
            from kinolab.dynamics.codegen.derived_code import derivations_of

            return tuple(map(ModeFormulas.of, derivations_of(self.system)))

        return FORMULAS.get([self.key], made)

    @cached_property
    def system(self) -> Mechanism:
        """What is derived; described anew where the model came from the cache."""
        return self._describe()

    @cached_property
    def attitudes(self) -> dict[str, int]:
        """Where in a state the quaternion of each attitude begins, by the attitude's name."""
        return {part.name: part.first for part in self._parts if isinstance(part, Rotations)}

    @cached_property
    def space(self) -> StateSpace:
        """Differences of states and steps along them, on lines, circles and spheres."""
        return StateSpace(self._parts, self._code.address)

    @property
    def circular(self) -> NDArray[np.bool_]:
        """Whether each entry of x is an angle on the circle, shape (nx,)."""
        return self.space.circular

    @cached_property
    def speeds(self) -> NDArray[np.int64]:
        """Which entries of a state are velocities: rates, and speeds that are auxiliary states."""
        first = self.nx - len(self.machine.states)
        further = [first + k for k, s in enumerate(self.machine.states) if s.is_speed]
        return np.array([*range(self.nq, first), *further], dtype=np.int64)

    def address(self, function: str) -> int:
        """Return the address of a compiled C function: f, step_rk4, frames, point_speed, …"""
        return self._code.address(function)

    def in_lanes(self, method: str) -> tuple[int, int]:
        """Return the addresses of a method's step and of f for several states at once, or zeros.

        They take what a step and f take, with ``LANES`` states, inputs and results entry by entry,
        and return bits that are set for lanes in which they failed. There are none of machines with
        modes or feedback, of very long equations of motion and of implicit methods.
        """
        return self._code.in_lanes(method)

    @cached_property
    def plant(self) -> Model:
        """The machine without its feedback: itself where it has none."""
        if self.machine.references is None:
            return self
        if self._alike is not None:
            return self._alike[0].plant.with_values(self._alike[1])
        return Model.described_by(f"{self.key} without feedback", partial(_plant_of, self))

    def plant_inputs(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the plant's inputs that the feedback gives under references, shape (..., nu).

        Args:
            x: State, shape (nx,), or states, shape (N, nx).
            u: References, shape (nr,), or one row per state; without feedback the inputs, which
                are returned as they are.
        """
        if self.machine.references is None:
            return self._inputs(u, _array("x", x, self.nx))
        return self._call("law", x, u, parameters)

    def parameter_vector(self, **parameters: float) -> Array:
        """Return the parameters as compiled code takes them, shape (number of parameters,).

        Raises:
            UnknownNameError: If a parameter does not exist.
        """
        vector = self._defaults.copy()
        for name, value in parameters.items():
            if name not in self.parameter_names:
                raise UnknownNameError("parameter", name, known=self.parameter_names)
            vector[self.parameter_names.index(name)] = value
        return vector

    def f(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the state derivative.

        Args:
            x: State, shape (nx,), or states, shape (N, nx).
            u: Inputs, shape (nu,), or one row per state, shape (N, nu); zero when left out.

        Returns:
            Derivative of the shape of ``x``.

        Raises:
            SingularError: Where the equations have no unique solution.
        """
        return self._call("f", x, u, parameters)

    def rate_under(self, u: ArrayLike, **parameters: float) -> Callable[[float, Array], Array]:
        """Return f under inputs that are held, as a function of time in [s] and state, shape (nx,).

        It is what integrators call again and again: what does not change is looked up once.

        Raises:
            SingularError: From the function, where the equations have no unique solution.
        """
        x, out = np.empty(self.nx), np.empty(self.nx)
        held = np.ascontiguousarray(self._inputs(u, x))
        f = bound(self.address("f"), x, held, self.parameter_vector(**parameters), out)

        def rate(_: float, state: Array) -> Array:
            x[:] = state
            status = f()
            if status:
                raise SingularError(_failure(self, status, x))
            return out.copy()

        return rate

    def step(
        self,
        x: ArrayLike,
        u: ArrayLike,
        dt: float | Array,
        *,
        method: str = "rk4",
        substeps: int = 1,
        **parameters: float,
    ) -> Array:
        """Return the state after one integrator step with the inputs held.

        Of a machine with modes, a step makes the transitions on its way in their order. A guard
        that becomes negative and positive again within a step is found if it falls at the step's
        beginning and rises at its end; one that does so twice takes shorter steps.

        Args:
            x: State, shape (nx,), or states, shape (N, nx).
            u: Inputs, shape (nu,), or one row per state.
            dt: Step length in [s], or one per state, shape (N,).
            method: One of ``methods``; ``rosenbrock`` for stiff friction.
            substeps: Of which the step is made.

        Raises:
            SingularError: Where the equations have no unique solution along the step.
        """
        states = _array("x", x, self.nx)
        rows, inputs = np.atleast_2d(states), np.atleast_2d(self._inputs(u, states))
        out, spans = np.empty_like(rows), np.broadcast_to(_numbers("dt", dt), len(rows))
        self._step_rows(rows, inputs, out, spans, method, substeps, parameters)
        return out.reshape(states.shape)

    def steps(
        self,
        x: ArrayLike,
        u: ArrayLike,
        spans: ArrayLike,
        *,
        method: str = "rk4",
        substeps: int = 1,
        **parameters: float,
    ) -> Array:
        """Return the states from one integrator step to the next, shape (N+1, nx).

        Args:
            x: State before the first step, shape (nx,).
            u: Inputs held in each step, shape (N, nu).
            spans: Lengths of the steps in [s], shape (N,).
            method: As in ``step``.
            substeps: Of which each step is made.

        Raises:
            SingularError: Where a step fails; its ``row`` says which.
        """
        spans = np.asarray(spans, dtype=float)
        states = np.empty((len(spans) + 1, self.nx))
        states[0] = _array("x", x, self.nx)
        inputs = self._inputs(u, states[:-1])
        self._step_rows(states[:-1], inputs, states[1:], spans, method, substeps, parameters)
        return states

    def _step_rows(
        self,
        rows: Array,
        inputs: Array,
        out: Array,
        spans: Array,
        method: str,
        substeps: int,
        parameters: Mapping[str, float],
    ) -> None:
        """Make one step from every row; what comes out may be the next row."""
        if method not in self.methods:
            raise UnknownNameError("integration method", method, known=self.methods)
        p = self.parameter_vector(**parameters)
        row, status = self._code.step(method, (rows, inputs, out), p, spans, substeps)
        if status:
            raise SingularError(_failure(self, status, rows[row]), row=row)

    def mode(self, x: ArrayLike) -> str:
        """Return the name of the mode in which a state is; empty where a machine has none."""
        names = self.machine.modes
        return names[int(_array("x", x, self.nx)[-1])] if names else ""

    def transition(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> str:
        """Return the name of the transition that takes place at a state (nx,); empty for none.

        Raises:
            SingularError: If what a transition waits for is undefined there.
        """
        states = _array("x", x, self.nx)
        if not self.machine.modes:
            return ""
        found = self._switch("leaves", states, u, parameters, np.zeros(1))
        leaving = self.machine.transitions_from(states)
        return leaving[int(found[0]) - 1].name if found[0] else ""

    def reset(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the state after the transition that takes place at a state, else the same one.

        Args:
            x: State, shape (nx,).
            u: Inputs, shape (nu,).

        Raises:
            SingularError: If the impact or the reset is undefined there.
        """
        states = _array("x", x, self.nx)
        if not self.machine.modes:
            return states.copy()
        return self._switch("reset", states, u, parameters, states.copy())

    def guards(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return what the transitions of a state's mode wait for, shape (..., transitions, 3).

        Of each: the expression that falls to zero, its rate in [1/s], and what must be positive.
        Modes with fewer transitions than others have rows of 1, 0, 0 at the end.

        Args:
            x: State, shape (nx,), or states, shape (N, nx).
            u: Inputs, shape (nu,), or one row per state.
        """
        sources = [transition.source for transition in self.machine.transitions]
        most = max(map(sources.count, sources), default=0)
        out = self._call("guards", x, u, parameters, size=1 + 3 * most)
        return out[..., 1:].reshape(*out.shape[:-1], most, 3)

    def after_transition(
        self, x: ArrayLike, u: ArrayLike, number: int, **parameters: float
    ) -> Array:
        """Return the states after a transition, whether it takes place at those before or not.

        Args:
            x: State, shape (nx,), or states, shape (N, nx), all of one mode.
            u: Inputs, shape (nu,), or one row per state.
            number: Of the transition among those from that mode, from 1.
        """
        return self._call("through", x, u, parameters, size=self.nx, number=number)

    def frames(self, x: ArrayLike, **parameters: float) -> Array:
        """Return the bodies' poses as rows of [R | p], shape (..., bodies, 12)."""
        out = self._call("frames", x, None, parameters)
        return out.reshape(*out.shape[:-1], out.shape[-1] // POSE, POSE)

    def frames_jacobian(self, x: ArrayLike, **parameters: float) -> Array:
        """Return the exact derivatives of ``frames`` by the entries of a state.

        Returns:
            Shape (..., bodies, 12, nx); those by entries that are no coordinates are zero.
        """
        out = self._call("frames_jacobian", x, None, parameters)
        bodies = out.shape[-1] // (self.nx * POSE)
        columns = out.reshape(*out.shape[:-1], self.nx, bodies, POSE)
        return np.ascontiguousarray(np.moveaxis(columns, -3, -1))

    def cables(self, x: ArrayLike, **parameters: float) -> Array:
        """Return both ends of every cable in the world, in [m], shape (..., cables, 2, 3)."""
        out = self._call("cables", x, None, parameters)
        return out.reshape(*out.shape[:-1], -1, 2, 3)

    def point_speed(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return a bound on the speed of each body's points in [m/s], shape (..., bodies).

        The spin of a shape about its own axis of symmetry is no motion and does not count.
        """
        return self._call("point_speed", x, u, parameters)

    def cable_speed(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return a bound on the speed of each cable's points in [m/s], shape (..., cables)."""
        return self._call("cable_speed", x, u, parameters)

    def jacobian(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> tuple[Array, Array]:
        """Return the exact derivatives of f at a state.

        Returns:
            df/dx of shape (..., nx, nx) and df/du of shape (..., nx, nu).
        """
        out = self._call("jacobian", x, u, parameters)
        columns = out.reshape(*out.shape[:-1], self.nx + self.nu, self.nx)
        both = np.swapaxes(columns, -1, -2)
        return both[..., : self.nx].copy(), both[..., self.nx :].copy()

    def mass_matrix(self, q: ArrayLike, **parameters: float) -> Array:
        """Return the mass matrix in full coordinates, shape (..., nt, nt).

        Args:
            q: Configuration, shape (nq,) or (N, nq); a whole state is accepted too.

        Raises:
            NoDynamicsError: If the machine is kinematic.
        """
        self._need_masses("mass matrix")
        values = np.asarray(q, dtype=float)
        if values.shape[-1:] == (self.nq,):
            padding = np.zeros((*values.shape[:-1], self.nx - self.nq))
            values = np.concatenate([values, padding], axis=-1)
        out = self._call("mass_matrix", values, None, parameters)
        return out.reshape(*out.shape[:-1], self.nt, self.nt)

    def energy(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> tuple[Any, Any]:
        """Return (kinetic, potential) energy in [J], floats or arrays of shape (N,).

        Raises:
            NoDynamicsError: If the machine is kinematic.
        """
        self._need_masses("energy")
        out = self._call("energy", x, u, parameters)
        kinetic, potential = out[..., 0], out[..., 1]
        return (float(kinetic), float(potential)) if out.ndim == 1 else (kinetic, potential)

    def power(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Any:
        """Return the power in [W] of all forces that are not conservative; shape (...).

        Raises:
            NoDynamicsError: If the machine is kinematic.
        """
        self._need_masses("power")
        out = self._call("power", x, u, parameters)[..., 0]
        return float(out) if out.ndim == 0 else out

    def constraint_residual(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return w(q) q_dot of every constraint, then h(q) of those of position; SI units.

        Shape (..., number of constraints + number of position constraints).
        """
        return self._call("constraint_residual", x, u, parameters)

    @cached_property
    def residual_names(self) -> tuple[str, ...]:
        """The constraint's name for each entry of ``constraint_residual``."""
        constraints = self.machine.constraints
        closed = (c.name for c in constraints if c.of_position)
        return (*(c.name for c in constraints), *closed)

    def constraint_forces(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the multiplier of every constraint and rate input; shape (..., rows).

        A constraint on a velocity in [m/s] has its force in [N], one in [rad/s] in [N m].
        """
        return self._call("constraint_forces", x, u, parameters)

    def requirements(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the margins that a plan must keep at least zero; shape (..., requirements)."""
        return self._call("requirements", x, u, parameters)

    def project(self, x: ArrayLike, **parameters: float) -> Array:
        """Return a state moved onto the constraints, its quaternions of unit length."""
        states = _array("x", x, self.nx)
        if not self.projects:
            return states.copy()
        near = self._call("project", states, None, parameters)
        return self._call("project", near, None, parameters)

    def rest(self) -> Array:
        """Return the state in which a machine starts unless told otherwise, shape (nx,).

        Everything is 0, or at the limit nearest to it, and attitudes are not turned.
        """
        x = np.clip(np.zeros(self.nx), *self.state_bounds.T)
        x[[part.pole for part in spheres_of(self._parts)]] = 1.0
        return x

    def null_control(self) -> Array:
        """Return the inputs that are nearest to zero within their limits, shape (nu,)."""
        return np.clip(np.zeros(self.nu), *self.control_bounds.T)

    def configuration(self, x: ArrayLike) -> Array:
        """Return the coordinates q of a state, shape (..., nq)."""
        return _array("x", x, self.nx)[..., : self.nq].copy()

    def velocity(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return all velocities, the dependent ones included, shape (..., nt)."""
        return self._call("velocity", x, u, parameters)

    def _need_masses(self, what: str) -> None:
        if not self._code.sizes["energy"]:
            kinematic = f"{self.machine.name} is kinematic: its inputs are velocities"
            raise NoDynamicsError(f"{kinematic}, so it has no {what}.")

    def equations(self) -> Equations:
        """Return the equations of motion for reading, in the author's symbols."""
        from kinolab.dynamics.lagrange.equations import equations_of

        return equations_of(self.system)

    def _call(
        self,
        name: str,
        x: ArrayLike,
        u: ArrayLike | None,
        parameters: dict[str, float],
        size: int | None = None,
        number: int = 0,
    ) -> Array:
        """Call a compiled function of (x, [u,] p) on a state or on each of several."""
        states = _array("x", x, self.nx)
        rows = np.atleast_2d(states)
        tables = [rows] if u is None else [rows, np.atleast_2d(self._inputs(u, states))]
        out = np.empty((len(rows), self._code.sizes[name] if size is None else size))
        p = self.parameter_vector(**parameters)
        row, status = self._code.evaluate(name, tables, p, out, number)
        if status:
            raise SingularError(_failure(self, status, rows[row]))
        return out.reshape(*states.shape[:-1], out.shape[1])

    def _switch(
        self, name: str, x: Array, u: ArrayLike, parameters: dict[str, float], out: Array
    ) -> Array:
        """Call a compiled function of transitions on one state, and return what it writes."""
        p = self.parameter_vector(**parameters)
        if status := bound(self.address(name), x, self._inputs(u, x), p, out)():
            raise SingularError(_failure(self, status, x))
        return out

    def _inputs(self, u: ArrayLike, states: Array) -> Array:
        values = _numbers("u", u)
        shape = (*states.shape[:-1], self.nu)
        if values.size == 0:
            return np.zeros(shape)
        if values.shape[-1:] != (self.nu,):
            what = f"u has shape {values.shape}; the last axis must be {self.nu}."
            names = ", ".join(self.control_names)
            raise InputError([Mistake(f"system {self.machine.name!r}", what, f"Inputs: {names}.")])
        if values.shape not in ((self.nu,), shape):
            what = f"u has shape {values.shape} where x has {states.shape}."
            remedy = f"Give one row of {self.nu} for all states, or one per state."
            raise InputError([Mistake(f"system {self.machine.name!r}", what, remedy)])
        return np.ascontiguousarray(np.broadcast_to(values, shape))


def _require_law(system: Mechanism) -> Feedback | None:
    """Return a machine's feedback; its gains must have been found.

    Raises:
        InputError: If its regulator is still to be designed.
    """
    from kinolab.dynamics.language.feedback import Regulator

    if isinstance(system.feedback, Regulator):
        remedy = "Take system.model(), which finds them."
        where = f"system {system.name!r} feedback"
        raise InputError([Mistake(where, "its gains are still to be found.", remedy)])
    return system.feedback


def _plant_of(model: Model) -> Mechanism:
    return model.system.with_feedback(None)


def _entries(
    machine: MachineFacts, quasi: Sequence[QuasiVelocityFacts], independent: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return each entry's limits (nx, 2) and its scale (nx,)."""
    limits = [c.limits for c in machine.coordinates for _ in c.entries]
    scales = [c.scale for c in machine.coordinates for _ in c.entries]
    owners = [c for c in machine.coordinates for _ in c.rates]
    moving: list[CoordinateFacts | QuasiVelocityFacts] = [*quasi, *(owners[i] for i in independent)]
    limits += [(-c.speed, c.speed) for c in moving] + [entry.limits for entry in machine.states]
    scales += [c.speed if np.isfinite(c.speed) else c.scale for c in moving]
    scales += [entry.scale for entry in machine.states]
    return np.array(limits).reshape(-1, 2), np.array(scales, dtype=float)


def _array(name: str, values: ArrayLike, size: int) -> Array:
    array = np.ascontiguousarray(_numbers(name, values))
    if array.ndim not in (1, 2) or array.shape[-1] != size:
        what = f"{name} has shape {array.shape}; it must be ({size},) or (N, {size})."
        raise InputError([Mistake("", what)])
    return array


def _numbers(name: str, values: ArrayLike) -> Array:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        what = f"{name} is not made of numbers."
        raise InputError([Mistake("", what, "Give an array of numbers.")]) from None


def _failure(model: Model, status: int, x: Array) -> str:
    cause = "the result is not finite"
    if status & CHATTERS:
        ways = ", ".join(t.name for t in model.machine.transitions_from(x))
        cause = f"transitions follow one another without end ({ways})"
    elif status & SINGULAR:
        cause = f"a velocity or mass is undetermined{_chart_left(model, x)}"
    state = ", ".join(f"{n}={v:.6g}" for n, v in zip(model.state_names, x, strict=True))
    text = f"{model.machine.name}: the equations of motion cannot be solved at {state}: {cause}"
    return text if text.endswith(".") else f"{text}."


def _chart_left(model: Model, x: Array) -> str:
    """Say how far outside the chart of the independent velocities a state is."""
    if not model.machine.constraints or model.machine.all_rates:
        return ""
    from kinolab.dynamics.derivation.singularity import condition_number, cure_of

    values = dict(zip(model.state_names, map(float, x), strict=True))
    try:
        number = condition_number(model.system, values | model.system.parameter_values)
    except (ArithmeticError, LookupError, ValueError):  # no value, or an input's is needed
        return " (outside the chart of the independent velocities)"
    where = f" (outside the chart of the independent velocities: condition number {number:.3g})"
    # 1e6: condition number from which velocities do not determine the motion
    return f"{where}. {cure_of(model.system)}" if number > 1e6 else where
