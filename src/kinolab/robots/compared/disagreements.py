"""Whether a machine moves as another engine's model of the same file.

M a + c - Q = 0 are the equations of motion without contacts, limits, dry friction and actuators. At
random positions, rates and accelerations both sides are compared: that the left ones agree for all
of these says that the same forces cause the same accelerations. Joints that follow others, and
those that are locked, are projected onto what moves: the velocities of all joints are S times those
of the machine, and forces along these S^T times the engine's. Where loops are closed, the engine's
constraints must be closed, too, and hold the same directions as the machine's.

Differences are relative to the sum of the sizes of the terms, as rounding is: accelerations
themselves lose as many digits as the mass matrix has decades.

Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section 1.5 (backward
errors).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from kinolab.dynamics import System
from kinolab.dynamics.derivation.sampled_states import feasible_values, sampled_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.errors import Mistake
from kinolab.lazy import versions_of
from kinolab.numerics.arrays import Array
from kinolab.robots.compared.machine_forces import MachineForces
from kinolab.robots.compared.second_engine import AbstractSecondEngine
from kinolab.robots.tree.kinematic_tree import Joint, coordinate_names, led
from kinolab.robots.tree.loop_closures import OPEN, STILL
from kinolab.store import Kind, code_in

STATES = 2  # one tells any two machines apart, but for those that agree there by chance
SAME = 10 * STILL  # [m/rad] and the like, of directions: what is still is left out of constraints
REMEDY = "This is a mistake in kinolab; please report it, with the file."
# Files that agreed are kept: MuJoCo and Pinocchio take longer to import than most files to be read.
PACKAGE = Path(__file__).parents[2]
LIBRARIES = ("yourdfpy", "lxml", "sympy", "numpy", "mujoco", "pin")  # the last is Pinocchio
AGREED: Kind[bytes] = Kind("agreed", bytes, bytes)


@dataclass(frozen=True)
class Correspondence:
    """Where an engine's joints are, by a machine's coordinates.

    Attributes:
        coordinates: Names of the machine's coordinates, by the joints that have their own.
        linear: Coordinate, factor and offset of joints at a linear function of one.
        held: Positions of joints that do not move.
    """

    coordinates: Mapping[str, tuple[str, ...]]
    linear: Mapping[str, tuple[str, float, float]]
    held: Mapping[str, float]

    @classmethod
    def of(
        cls,
        joints: Mapping[str, Joint],
        held: Mapping[str, float],
        further: Mapping[str, tuple[str, ...]],
    ) -> Correspondence:
        """Return that of a tree's joints by name, some of them held, and of further ones."""
        moving = [j for j in joints.values() if j.kind != "fixed" and j.name not in held]
        own = {**further, **{j.name: coordinate_names(j) for j in moving if j.mimics is None}}
        linear = {}
        for joint in moving:
            if joint.mimics is not None:
                leader, factor, offset = led(joint, joints)
                linear[joint.name] = own[leader][0], factor, offset
        return cls(own, linear, held)

    @property
    def joints(self) -> set[str]:
        """Names of all joints that an engine has."""
        return {*self.coordinates, *self.linear, *self.held}


def disagreements(
    system: System,
    joints: Correspondence,
    engines: Iterable[AbstractSecondEngine],
    where: str,
    neglected: float = 0.0,
) -> Iterator[Mistake]:
    """Yield in what a machine differs from an engine's model of the same file, at most one thing.

    Args:
        joints: What its coordinates are in the file.
        engines: Which read the same file.
        where: What mistakes are reported for.
        neglected: Moments of inertia that kinolab took for rounding and left out, in [kg m^2].
    """
    own, found = None, None
    for engine in engines:
        if other := sorted(joints.joints ^ engine.rates.keys()):
            who, lacks = engine.name, "kinolab's machine"
            who, lacks = (who, lacks) if other[0] in engine.rates else (lacks, who)
            found = other[0], f"it moves in {who}, not in {lacks}."
        else:
            own = own or _RandomStates(system)
            compared = _Comparison(own, joints, engine, neglected)
            found = compared.of_forces() or compared.of_constraints()
        if found:
            joint, what = found
            yield Mistake(f"{where} joint {joint!r}".strip(), what, REMEDY)
            return


class _RandomStates:
    """A machine at a few random states, with random accelerations.

    Attributes:
        entries: Names of the entries of each coordinate and of its rates, by its name.
        rates: Names of all n velocities.
        states: Values by name.
        closed: Whether its loops are closed in them; else no such state was found.
        a: Derivatives of the velocities, shape (m, n).
        forces: That its motion takes, shape (m, n).
        slopes: Of its constraints, shape (m, k, n).
    """

    def __init__(self, system: System) -> None:
        binding = SymbolTable.of(system)
        self.rates = binding.names(binding.tangent)
        self.entries = {
            c.name: ([s.name for s in c.entries], [s.name for s in c.rates])
            for c in system.coordinates
        }
        found = [*islice(feasible_values(binding), STATES + 1)]
        self.closed = bool(found)
        # The first state that is sampled is that of rest. Forces are defined in open loops, too.
        self.states = (found or [*sampled_values(binding, STATES + 1)])[-STATES:]
        generator = np.random.default_rng(0)
        self.a = generator.normal(size=(len(self.states), len(self.rates)))
        self.forces, self.slopes = MachineForces(system, binding)(self.states, self.a)


class _Comparison:
    """A machine and an engine."""

    def __init__(
        self,
        own: _RandomStates,
        joints: Correspondence,
        engine: AbstractSecondEngine,
        neglected: float,
    ) -> None:
        self._own, self._joints, self._theirs = own, joints, engine
        self._neglected = neglected + engine.neglected
        size = max((rates.stop for rates in engine.rates.values()), default=0)
        self._S = np.zeros((size, len(own.rates)))
        self._joint_of: dict[int, str] = {}  # by the machine's velocity
        for name, coordinates in joints.coordinates.items():
            rates = [rate for one in coordinates for rate in own.entries[one][1]]
            columns = [own.rates.index(rate) for rate in rates]
            self._S[engine.rates[name], columns] = np.eye(len(rates))
            self._joint_of |= dict.fromkeys(columns, name)
        for name, (coordinate, factor, _) in joints.linear.items():
            self._S[engine.rates[name], own.rates.index(f"{coordinate}_dot")] = factor

    def of_forces(self) -> tuple[str, str] | None:
        """Return the joint whose force differs most, and what it is; None if none differs."""
        own, S, worst, found = self._own, self._S, 1.0, None
        for state, a, ours in zip(own.states, own.a, own.forces, strict=True):
            v = np.array([state[name] for name in own.rates])
            forces, sizes = self._theirs.forces(self._at(state), S @ v, S @ a)
            theirs, sizes = S.T @ forces, np.abs(S).T @ sizes
            # Positions are rounded beside all of a robot, which of a light part is more.
            allowed = 1e-9 * sizes + 1e-14 * sizes.max(initial=0.0)
            allowed += self._neglected * (np.abs(S @ a).sum() + np.abs(S @ v).sum() ** 2)
            with np.errstate(divide="ignore", invalid="ignore"):
                shares = np.abs(ours - theirs) / allowed
            shares[np.isnan(shares) & (ours == theirs)] = 0.0
            shares[np.isnan(shares)] = np.inf
            k = int(shares.argmax()) if len(shares) else 0
            if len(shares) and shares[k] > worst:
                worst = float(shares[k])
                shown = f"{theirs[k]:.12g} in {self._theirs.name}, and {ours[k]:.12g} in kinolab"
                found = self._joint_of[k], f"a random motion takes there, in SI units, {shown}."
        return found

    def of_constraints(self) -> tuple[str, str] | None:
        """Return a joint that constraints hold otherwise, and which; None if none does."""
        name, states = self._theirs.name, self._own.states if self._own.closed else []
        for state, own in zip(states, self._own.slopes, strict=False):
            held = self._theirs.held(self._at(state))
            for k in np.flatnonzero(~(np.abs(held.gaps) <= OPEN))[:1]:
                what = f"{held.names[k]} is {abs(held.gaps[k]):.3g} apart in {name}"
                return self._most(held.slopes[k]), f"{what}, where it is closed in kinolab."
            slopes = held.slopes @ self._S
            for rows, others, who in ((slopes, own, name), (own, slopes, "kinolab's machine")):
                beside = np.abs(_beside(rows, others)).max(axis=0, initial=0.0)
                if not (beside <= SAME * max(1.0, np.abs(rows).max(initial=0.0))).all():
                    joint = self._joint_of[int(beside.argmax())]
                    return joint, f"a constraint holds it in {who} alone."
        return None

    def _at(self, state: Mapping[str, float]) -> dict[str, Array]:
        """Return where each joint is."""
        joints = self._joints
        at = {name: np.array([where]) for name, where in joints.held.items()}
        for name, coordinates in joints.coordinates.items():
            entries = [entry for one in coordinates for entry in self._own.entries[one][0]]
            at[name] = np.array([state[entry] for entry in entries])
        for name, (coordinate, factor, offset) in joints.linear.items():
            at[name] = np.array([factor * state[coordinate] + offset])
        return at

    def _most(self, slopes: Array) -> str:
        """Return the joint of the engine to which the largest of some slopes belongs."""
        k = int(np.abs(slopes).argmax())
        return next(name for name, own in self._theirs.rates.items() if own.start <= k < own.stop)


def _beside(rows: Array, others: Array) -> Array:
    """Return what of rows (m, n) is no combination of others (k, n), shape (m, n)."""
    if not rows.size or not others.size:
        return rows
    shares = np.linalg.lstsq(others.T, rows.T, rcond=STILL)[0]
    beside: Array = rows - shares.T @ others
    return beside


def agreement_on(file: bytes, base: str, locked: Mapping[str, float]) -> list[str | bytes]:
    """Return all that determines whether engines agree: the file, how it is read, and by what."""
    code = [code_in(PACKAGE / room) for room in ("robots", "dynamics", "numerics")]
    how = [base, sorted(locked.items()), versions_of(*LIBRARIES)]
    return [file, json.dumps(how), *code]
