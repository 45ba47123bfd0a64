"""A machine under examination: where it is looked at, and how its bodies move there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy

from kinolab.dynamics import Body, Coordinate, Frame, Model, System
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.mechanism_parts import (
    AnyCoordinate,
    atoms_of,
    coordinate_of,
    energies_in,
    imposed_accelerations,
    imposed_velocities,
    loads_in,
)
from kinolab.dynamics.language.quantities import Change, FrameSpeed, written
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array

SAMPLES = 12  # random velocities at a configuration
UNLIMITED = 1e3  # sampled limit of a velocity or an input without one, in its unit


@dataclass(frozen=True)
class Subject:
    """A machine without its controller, and what is asked of its motions.

    Attributes:
        system: The machine; it has one mode.
    """

    system: System

    @cached_property
    def model(self) -> Model:
        """Its equations of motion."""
        return self.system.model()

    @cached_property
    def rest(self) -> Array:
        """Where it starts unless told otherwise, on its constraints, shape (nx,)."""
        return self.on_constraints(self.model.rest())

    @property
    def rests_within_limits(self) -> bool:
        """Whether that is where the limits of all coordinates let it be."""
        low, high = self.model.state_bounds[: self.model.nq].T
        at, slack = self.rest[: self.model.nq], 1e-9 * self.model.state_scales[: self.model.nq]
        return bool(np.all((at >= low - slack) & (at <= high + slack)))

    def on_constraints(self, x: Array, **values: float) -> Array:
        """Return a state (nx,) moved onto the position constraints; the same where that fails."""
        try:
            for _ in range(20):  # onto position constraints; each squares what is left
                x = self.model.project(x, **values)
        except KinolabError:
            pass
        return x

    @cached_property
    def plain(self) -> dict[Coordinate, int]:
        """Coordinates that are one number, each with its place in a state."""
        names = self.model.state_names
        plain = (c for c in self.system.coordinates if isinstance(c, Coordinate))
        return {c: names.index(c.name) for c in plain if c.topology != "sphere"}

    @property
    def turning(self) -> list[AnyCoordinate]:
        """The coordinates that turn a body about every axis: those with several rates."""
        return [c for c in self.system.coordinates if len(c.rates) > 1]

    def places_of(self, coordinate: AnyCoordinate) -> list[int]:
        """Return the places of a coordinate's entries in a state."""
        return [self.model.state_names.index(str(entry)) for entry in coordinate.entries]

    def moving(self, frame: Frame) -> frozenset[str]:
        """Return the names of the coordinates on which a frame depends."""
        owners = (coordinate_of(atom) for atom in atoms_of(frame))
        return frozenset(owner.name for owner in owners if owner is not None)

    def span(self, coordinate: Coordinate) -> float:
        """Return how far a coordinate may move from rest, in its unit: its scale, or to a limit."""
        at = self.rest[self.plain[coordinate]]
        ways = [coordinate.lower - at, coordinate.upper - at, coordinate.scale]
        if not np.isfinite(ways[:2]).any():
            return float(coordinate.scale)
        return float(max(ways[:2], key=lambda way: min(abs(way), coordinate.scale)))

    def moved(self, shares: dict[Coordinate, float], turned: float = 0.0) -> Array:
        """Return the state in which coordinates have moved by shares of their spans.

        What turns about every axis is turned by about an angle in [rad], about one askew to all.
        """
        x = self.rest.copy()
        for turning in self.turning:
            x[self.places_of(turning)] += np.multiply(turned / 2, (0.6, 0.64, 0.48, 0.0))
        x = self.model.space.unit(x)
        for coordinate, share in shares.items():
            x[self.plain[coordinate]] += share * self.span(coordinate)
        return self.on_constraints(x)

    def in_motion(self, x: Array) -> tuple[Array, Array]:
        """Return random motions that the constraints allow at a configuration.

        Returns:
            Rates of the entries of a configuration, shape (SAMPLES, nq), and of all coordinates,
            shape (SAMPLES, nt).

        Raises:
            KinolabError: Where the equations of motion are singular.
        """
        model, generator = self.model, np.random.default_rng(0)
        states = np.repeat(x[None], SAMPLES, axis=0)
        limits = np.clip(model.control_bounds, -UNLIMITED, UNLIMITED)
        sizes = np.minimum(model.state_scales, UNLIMITED)[model.speeds]
        states[:, model.speeds] = sizes * generator.uniform(-1, 1, (SAMPLES, len(sizes)))
        inputs = generator.uniform(limits[:, 0], limits[:, 1], (SAMPLES, model.nu))
        return model.f(states, inputs)[:, : model.nq], model.velocity(states, inputs)

    def begun(self, x: Array, u: Array) -> Array:
        """Return how the rates of a configuration's entries begin to change from rest.

        Args:
            x: States at rest, shape (..., nx).
            u: Inputs, shape (..., nu).

        Returns:
            Accelerations, shape (..., nq): those of entries are linear in those of velocities.
        """
        model, moving = self.model, x.copy()
        moving[..., model.speeds] = model.f(x, u)[..., model.speeds]
        rates: Array = model.f(moving, u)[..., : model.nq]
        return rates

    def poses(self, x: Array) -> Array:
        """Return the bodies' poses [R | p], shape (..., bodies, 3, 4)."""
        flat = self.model.frames(x)
        return flat.reshape(*flat.shape[:-1], 3, 4)

    def poses_by(self, x: Array) -> Array:
        """Return their derivatives by the configuration, shape (bodies, 3, 4, nq)."""
        slopes = self.model.frames_jacobian(x)[..., : self.model.nq]
        return slopes.reshape(len(self.system.bodies), 3, 4, -1)

    def spin(self, body: Body, x: Array) -> Array:
        """Return a body's angular velocity by the rates of entries, shape (3, nq)."""
        k = self.place_of(body)
        spin = np.einsum("ijk,lj->ilk", self.poses_by(x)[k][:, :3], self.poses(x)[k][:, :3])
        return np.asarray([spin[2, 1], spin[0, 2], spin[1, 0]])

    def slip(self, body: Body, base: Body | None, point: Array, x: Array) -> Array:
        """Return the velocity of a body at a point against another, by the rates of entries.

        Args:
            base: The other; None for the world.
            point: In the world, in [m].
            x: State, shape (nx,).

        Returns:
            Shape (3, nq).
        """
        poses, slopes = self.poses(x), self.poses_by(x)

        def carried(one: Body) -> Array:
            pose, slope = poses[self.place_of(one)], slopes[self.place_of(one)]
            own = pose[:, :3].T @ (point - pose[:, 3])
            return np.asarray(np.einsum("ijk,j->ik", slope[:, :3], own) + slope[:, 3])

        return carried(body) - (0.0 if base is None else carried(base))

    def carriers(self, body: Body) -> list[Body]:
        """Return the bodies that move by some of a body's coordinates, those by most first."""
        own = self.moving(body.frame)
        found = [one for one in self.system.bodies if self.moving(one.frame) < own]
        return sorted(found, key=lambda one: -len(self.moving(one.frame)))

    def place_of(self, body: Body) -> int:
        """Return the row of a body in the tables of poses."""
        return self.system.bodies.index(body)

    @cached_property
    def driven(self) -> frozenset[str]:
        """Names of the coordinates along which more acts than friction and weight."""
        system = self.system
        stated = [c.velocity for c in system.constraints]
        stated += [entry.velocity for entry in imposed_velocities(system)]
        words: tuple[Input | Effort, ...] = (*system.inputs, *system.efforts)
        for word in words:
            energies = list(energies_in(word))
            if energies or not getattr(word, "size", ""):
                stated += [*map(written, energies), *(written(v.velocity) for v in loads_in(word))]
        owners = (coordinate_of(atom) for part in stated for atom in atoms_of(part))
        named = (owner.name for owner in owners if owner is not None)
        return frozenset((*named, *imposed_accelerations(system)))

    @cached_property
    def pushed(self) -> frozenset[str]:
        """Names of the coordinates along which inputs act, by themselves or in forces."""
        system, symbols = self.system, {entry.symbol for entry in self.system.inputs}
        users = [e for e in system.efforts if symbols & set(atoms_of(e))]
        words: tuple[Input | Effort, ...] = (*system.inputs, *users)
        loads = [v.velocity for word in words for v in loads_in(word)]
        stated = (*map(written, loads), *(v.velocity for v in imposed_velocities(system)))
        owners = (coordinate_of(atom) for part in stated for atom in atoms_of(part))
        named = (owner.name for owner in owners if owner is not None)
        return frozenset((*named, *imposed_accelerations(system)))

    @cached_property
    def pushed_along(self) -> tuple[tuple[sympy.Expr, frozenset[sympy.Symbol]], ...]:
        """Velocities along which forces act or which are imposed, with their symbols.

        Ropes and springs are left out: they act along distances of origins and rub on nothing.
        """
        loads = (load.velocity for e in self.system.efforts for load in loads_in(e))
        imposed = (entry.velocity for entry in imposed_velocities(self.system))
        stated = (written(v) for v in (*loads, *imposed) if not _is_change(v))
        return tuple((one, frozenset(atoms_of(one))) for one in stated)


def _is_change(velocity: sympy.Expr | FrameSpeed) -> bool:
    return isinstance(velocity, sympy.Expr) and bool(velocity.atoms(Change))
