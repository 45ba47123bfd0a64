"""What pushes a machine, as loads of its joints: friction, springs, motors and thrusters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.forces import Effort, Load
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate, energies_in, loads_in
from kinolab.dynamics.language.quantities import FrameQuantity, FrameSpeed
from kinolab.dynamics.symbols.expressions import exact, is_zero
from kinolab.dynamics.symbols.symbols import Coordinate, rate
from kinolab.errors import Mistake
from kinolab.robots.actuation.actuators import Motor, Thruster
from kinolab.robots.writing.frame_chains import FrameChains
from kinolab.robots.writing.input_pushes import InputPushes

SMOOTHING = 0.01  # [m/s] or [rad/s] of Coulomb friction, where a file does not say it


@dataclass
class JointLoad:
    """Friction and a spring, in terms of a joint's position: see ``Joint``."""

    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class Loads:
    """What pushes a machine, and what of it has no counterpart in a tree."""

    joints: Mapping[AnyCoordinate, JointLoad]
    motors: tuple[Motor, ...]
    thrusters: tuple[Thruster, ...]
    cannot: tuple[Mistake, ...]


def loads_of(
    system: Mechanism, chains: FrameChains, factors: Mapping[AnyCoordinate, float]
) -> Loads:
    """Return what pushes a machine.

    Args:
        chains: Of its frames.
        factors: Positions of joints, relative to their coordinates.
    """
    efforts = _Efforts(system, chains, factors)
    for effort in system.efforts:
        efforts.take(effort)
    pushes = InputPushes(system, chains, factors)
    found = [pushes.of(entry) for entry in system.inputs]
    return Loads(
        efforts.joints,
        tuple(entry for entry in found if isinstance(entry, Motor)),
        tuple(entry for entry in found if isinstance(entry, Thruster)),
        (*efforts.cannot, *(entry for entry in found if isinstance(entry, Mistake))),
    )


class _Efforts:
    """Takes what is no input as friction and springs of joints."""

    def __init__(
        self, system: Mechanism, chains: FrameChains, factors: Mapping[AnyCoordinate, float]
    ) -> None:
        self._system, self._chains = system, chains
        self._factors = dict.fromkeys(system.coordinates, 1.0) | dict(factors)
        self.joints = {c: JointLoad() for c in system.coordinates}
        self.cannot: list[Mistake] = []

    def take(self, effort: Effort) -> None:
        """Take a force, or note that it is none of a joint."""
        for energy in energies_in(effort):
            self._take_potential(effort, energy)
        for load in loads_in(effort):
            self._take_load(effort, load)

    def _cannot(self, effort: Effort, what: str, remedy: str) -> None:
        mistake = Mistake(str(effort), what, remedy)
        if mistake not in self.cannot:
            self.cannot.append(mistake)

    def _no_joint(self, effort: Effort) -> None:
        what = "it is no friction or spring of a joint."
        self._cannot(effort, what, "Springs of joints are written as Potential(k * q**2 / 2).")

    def _number(self, expression: sympy.Expr) -> sympy.Expr:
        return self._chains.numbers(sympy.sympify(expression))

    def _take_load(self, effort: Effort, load: Load) -> None:
        """Take what an unpowered machine's load is as damping or dry friction of a joint."""
        held = {entry.symbol: 0 for entry in self._system.inputs}
        magnitude = self._number(load.magnitude).subs(held)
        if is_zero(magnitude):
            return
        if isinstance(load.velocity, FrameSpeed):
            what = "no input gives it, or not all of it."
            self._cannot(effort, what, "Only multiples of inputs are written.")
            return
        if exact(load.velocity).has(FrameQuantity):
            self._no_joint(effort)
            return
        found = self._rate_in(load.velocity)
        if found is None or not self._take_friction(effort, magnitude, *found):
            what = "it is not that of one joint with a constant coefficient."
            self._cannot(effort, what, "Take the rate of a coordinate, as rate(q).")

    def _take_friction(
        self, effort: Effort, magnitude: sympy.Expr, c: Coordinate, factor: float
    ) -> bool:
        """Take a load along a multiple of a rate; return whether it is friction.

        Args:
            effort: The force of which it is a part.
            magnitude: In numbers and rates.
            factor: The velocity by its rate.
        """
        load, own = self.joints[c], abs(factor) / self._factors[c]
        slope = self._factor(magnitude, rate(c))
        if slope is not None:
            load.damping -= slope / factor * own**2
            return True
        slip = min(magnitude.atoms(sympy.tanh), key=str, default=sympy.Integer(0))
        strength, pace = self._factor(magnitude, slip), self._factor(sum(slip.args), rate(c))
        if strength is None or pace is None:
            return False
        smoothed = self._factors[c] / abs(pace)
        # 1e-11, relative: what differs less, differs by rounding
        if abs(smoothed - SMOOTHING) > 1e-11 * SMOOTHING:
            what = f"it is smoothed by {smoothed:g}, and that of files by {SMOOTHING:g}."
            self._cannot(effort, what, f"Give it smoothing={SMOOTHING * own:g}.")
        else:
            load.friction += abs(strength) * own
        return True

    def _factor(self, expression: sympy.Expr, of: sympy.Expr) -> float | None:
        """Return the constant that an expression is a multiple of another one by; None without."""
        if of == 0:
            return None
        factor = sympy.simplify(sympy.sympify(expression) / of)
        return None if factor.free_symbols or is_zero(factor) else float(factor)

    def _rate_in(self, velocity: sympy.Expr) -> tuple[Coordinate, float] | None:
        """Return the coordinate whose rate a velocity is, and the constant factor of it."""
        for c in (c for c in self._factors if isinstance(c, Coordinate)):
            factor = self._factor(self._number(velocity), rate(c))
            if factor is not None:
                return c, factor
        return None

    def _take_potential(self, effort: Effort, energy: sympy.Expr) -> None:
        """Take a sum of k_i (q_i - r_i)^2 / 2 as springs."""
        value = self._number(energy)
        coordinates = value.atoms(Coordinate)
        if coordinates != value.free_symbols:
            self._no_joint(effort)  # it is of places or attitudes
            return
        found: dict[Coordinate, tuple[float, float]] = {}
        for symbol in sorted(coordinates, key=str):
            slope = sympy.diff(value, symbol)
            bend = sympy.simplify(sympy.diff(slope, symbol))
            at_zero = sympy.simplify(slope - bend * symbol)
            linear = not bend.free_symbols and not at_zero.free_symbols
            if not linear or not bend > 0:
                what = f"its energy {energy} is not that of springs of joints."
                self._cannot(effort, what, "Write k * (q - q_0)**2 / 2 with k > 0.")
                return
            found[symbol] = float(bend), -float(at_zero / bend)
        for c, (stiffness, rest) in found.items():
            load, factor = self.joints[c], self._factors[c]
            before, own = load.stiffness, stiffness / factor**2
            load.stiffness += own
            load.rest = (before * load.rest + own * rest * factor) / load.stiffness
