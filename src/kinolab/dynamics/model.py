"""A compiled machine: equations of motion as functions of numbers."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.compilation import compile_ir
from kinolab.dynamics.derivation import Derivation, derive
from kinolab.dynamics.emission import METHODS, SINGULAR, emit_module
from kinolab.dynamics.system import System
from kinolab.errors import InputError, Mistake, SingularError, UnknownNameError

if TYPE_CHECKING:
    from kinolab.dynamics.equations import Equations

Array: TypeAlias = NDArray[np.float64]

POSE = 12  # numbers per body: the rows of [R | p]


class Model:
    """The equations of motion of a machine, compiled.

    A state x is (q, v): the coordinates, and the rates of those coordinates whose rates are
    independent. Angles are in rad and are not wrapped. Every method takes parameter values by
    keyword, which override the system's without compiling anything.

    Attributes:
        system: What was derived.
        state_names: Names of the entries of x, shape (nx,).
        control_names: Names of the entries of u, shape (nu,).
        rate_names: Names of all rates q_dot, shape (nt,).
        control_bounds: Lower and upper limit of each input, shape (nu, 2).
        state_bounds: Lower and upper limit of each entry of x, shape (nx, 2).
    """

    def __init__(self, system: System) -> None:
        derivation = derive(system)
        self.system = system
        self.independent: tuple[int, ...] = derivation.independent
        self._library = compile_ir(emit_module(derivation))
        self._sizes = _sizes(derivation)
        self.coordinate_names = tuple(c.name for c in system.coordinates)
        self.rate_names = tuple(f"{name}_dot" for name in self.coordinate_names)
        self.state_names = (
            *self.coordinate_names,
            *(self.rate_names[i] for i in derivation.independent),
        )
        self.control_names = tuple(entry.name for entry in system.inputs)
        self.control_bounds: Array = np.array(
            [entry.bounds for entry in system.inputs], dtype=float
        ).reshape(-1, 2)
        self.state_bounds: Array = np.array(
            [(c.lower, c.upper) for c in system.coordinates]
            + [
                (-system.coordinates[i].speed, system.coordinates[i].speed)
                for i in self.independent
            ]
        ).reshape(-1, 2)
        self.parameter_names = tuple(parameter.name for parameter in system.parameters)
        self._defaults = np.array([system.parameter_values[n] for n in self.parameter_names])

    @property
    def nx(self) -> int:
        """Number of entries of a state."""
        return len(self.state_names)

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return len(self.control_names)

    @property
    def nq(self) -> int:
        """Number of coordinates."""
        return len(self.coordinate_names)

    def address(self, function: str) -> int:
        """Return the address of a compiled C function: f, step_rk4, frames, point_speed, …"""
        return self._library.address(function)

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
        states = _array("x", x, self.nx)
        inputs = self._inputs(u, states)
        rows, controls = np.atleast_2d(states), np.atleast_2d(inputs)
        out = np.empty_like(rows)
        p = self.parameter_vector(**parameters)
        pointers = (_pointer(rows), _pointer(controls), _pointer(p), _pointer(out))
        bad = self._batch(len(rows), *pointers, 0)
        if bad >= 0:
            raise SingularError(_failure(self, SINGULAR, rows[bad]))
        return out.reshape(states.shape)

    def step(
        self, x: ArrayLike, u: ArrayLike, dt: float, *, method: str = "rk4", **parameters: float
    ) -> Array:
        """Return the state after one integrator step with the inputs held.

        Args:
            x: State, shape (nx,), or states, shape (N, nx).
            u: Inputs, shape (nu,), or one row per state.
            dt: Step length in [s].
            method: ``rk4`` or ``euler``.

        Raises:
            SingularError: Where the equations have no unique solution along the step.
        """
        if method not in METHODS:
            raise UnknownNameError("integration method", method, known=METHODS)
        states = _array("x", x, self.nx)
        inputs = self._inputs(u, states)
        out = np.empty_like(np.atleast_2d(states))
        p = self.parameter_vector(**parameters)
        function = self._steppers[method]
        for row, control, result in zip(
            np.atleast_2d(states), np.atleast_2d(inputs), out, strict=True
        ):
            status = function(
                _pointer(row), _pointer(control), _pointer(p), dt, _pointer(result), 0
            )
            if status:
                raise SingularError(_failure(self, status, row))
        return out.reshape(states.shape)

    def frames(self, x: ArrayLike, **parameters: float) -> Array:
        """Return the bodies' poses as rows of [R | p], shape (..., bodies, 12)."""
        out = self._call("frames", x, None, parameters)
        return out.reshape(*out.shape[:-1], -1, POSE)

    def point_speed(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return a bound on the speed of each body's points in [m/s], shape (..., bodies).

        The spin of a shape about its own axis of symmetry is no motion and does not count.
        """
        return self._call("point_speed", x, u, parameters)

    def mass_matrix(self, q: ArrayLike, **parameters: float) -> Array:
        """Return the mass matrix in full coordinates, shape (..., nt, nt).

        Args:
            q: Coordinates, shape (nq,) or (N, nq); a whole state is accepted too.
        """
        values = np.asarray(q, dtype=float)
        if values.shape[-1:] == (self.nq,):
            padding = np.zeros((*values.shape[:-1], self.nx - self.nq))
            values = np.concatenate([values, padding], axis=-1)
        out = self._call("mass_matrix", values, None, parameters)
        return out.reshape(*out.shape[:-1], self.nq, self.nq)

    def energy(self, x: ArrayLike, **parameters: float) -> tuple[Any, Any]:
        """Return (kinetic, potential) energy in [J], floats or arrays of shape (N,)."""
        out = self._call("energy", x, None, parameters)
        kinetic, potential = out[..., 0], out[..., 1]
        return (float(kinetic), float(potential)) if out.ndim == 1 else (kinetic, potential)

    def constraint_residual(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return w(q) q_dot, in [m/s] or [rad/s], shape (..., number of constraints)."""
        return self._call("constraint_residual", x, u, parameters)

    def configuration(self, x: ArrayLike) -> Array:
        """Return the coordinates q of a state, shape (..., nq)."""
        return _array("x", x, self.nx)[..., : self.nq].copy()

    def velocity(self, x: ArrayLike, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the rates of all coordinates, the dependent ones included, shape (..., nt)."""
        return self._call("velocity", x, u, parameters)

    def equations(self) -> Equations:
        """Return the equations of motion for reading, in the author's symbols."""
        return self.system.equations()

    def _call(
        self, name: str, x: ArrayLike, u: ArrayLike | None, parameters: dict[str, float]
    ) -> Array:
        """Call a compiled function of (x, [u,] p) on a state or on each of several."""
        function, size = self._function(name, with_inputs=u is not None), self._sizes[name]
        states = _array("x", x, self.nx)
        rows = np.atleast_2d(states)
        out = np.empty((len(rows), size))
        p = _pointer(keep := self.parameter_vector(**parameters))
        inputs = np.atleast_2d(self._inputs(u, states)) if u is not None else rows
        for row, control, result in zip(rows, inputs, out, strict=True):
            extra = (_pointer(control),) if u is not None else ()
            function(_pointer(row), *extra, p, _pointer(result), 0)
        del keep
        return out.reshape(*states.shape[:-1], size)

    def _inputs(self, u: ArrayLike, states: Array) -> Array:
        values = np.asarray(u, dtype=float)
        shape = (*states.shape[:-1], self.nu)
        if values.size == 0:
            return np.zeros(shape)
        if values.shape[-1:] != (self.nu,):
            what = f"u has shape {values.shape}; the last axis must be {self.nu}."
            names = ", ".join(self.control_names)
            raise InputError([Mistake(f"system {self.system.name!r}", what, f"Inputs: {names}.")])
        return np.ascontiguousarray(np.broadcast_to(values, shape))

    def _function(self, name: str, *, with_inputs: bool) -> Callable[..., int]:
        pointers = (ctypes.c_void_p,) * (4 if with_inputs else 3)
        return self._prototype(name, *pointers, ctypes.c_int64)

    def _prototype(self, name: str, *types: Any) -> Callable[..., int]:
        return ctypes.CFUNCTYPE(ctypes.c_int32, *types)(self.address(name))

    @cached_property
    def _batch(self) -> Callable[..., int]:
        types = (ctypes.c_int64, *(ctypes.c_void_p,) * 4, ctypes.c_int64)
        return ctypes.CFUNCTYPE(ctypes.c_int64, *types)(self.address("f_batch"))

    @cached_property
    def _steppers(self) -> dict[str, Callable[..., int]]:
        pointer = ctypes.c_void_p
        types = (pointer, pointer, pointer, ctypes.c_double, pointer, ctypes.c_int64)
        return {method: self._prototype(f"step_{method}", *types) for method in METHODS}


def _sizes(derivation: Derivation) -> dict[str, int]:
    return {
        "velocity": len(derivation.rates),
        "frames": len(derivation.frames),
        "point_speed": len(derivation.point_speeds),
        "energy": 2,
        "mass_matrix": len(derivation.mass_matrix),
        "constraint_residual": len(derivation.constraint_residual),
    }


def _array(name: str, values: ArrayLike, size: int) -> Array:
    array = np.ascontiguousarray(values, dtype=float)
    if array.ndim not in (1, 2) or array.shape[-1] != size:
        what = f"{name} has shape {array.shape}; it must be ({size},) or (N, {size})."
        raise InputError([Mistake("", what)])
    return array


def _pointer(array: Array) -> int:
    return int(array.ctypes.data)


def _failure(model: Model, status: int, x: Array) -> str:
    cause = (
        "a velocity or mass is undetermined (outside the chart of the independent velocities)"
        if status == SINGULAR
        else "the result is not finite"
    )
    state = ", ".join(f"{n}={v:.6g}" for n, v in zip(model.state_names, x, strict=True))
    return f"{model.system.name}: the equations of motion cannot be solved at {state}: {cause}."
