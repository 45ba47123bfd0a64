"""What pushes a machine, as loads of its joints: friction, springs, motors and thrusters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.expressions import is_zero
from kinolab.dynamics.language.forces import (
    Coulomb,
    Effort,
    Potential,
    Viscous,
    Wrench,
    effort_name,
)
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate
from kinolab.dynamics.language.symbols import Coordinate, rate
from kinolab.errors import Mistake
from kinolab.robots.kinematic_tree import Motor, Thruster
from kinolab.robots.writing.frame_chains import FrameChains
from kinolab.robots.writing.input_pushes import InputPushes, wrench_parts

SAME = 1e-11  # relative: what differs less, differs by rounding
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
        system: The machine.
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
        match effort:
            case Viscous():
                self._take_viscous(effort)
            case Coulomb():
                self._take_coulomb(effort)
            case Potential():
                self._take_potential(effort)
            case Wrench():
                held = {entry.symbol: 0 for entry in self._system.inputs}
                if not all(is_zero(self._number(p.subs(held))) for p in wrench_parts(effort)):
                    what = "no input gives it, or not all of it."
                    self._cannot(effort_name(effort), what, "Only multiples of inputs are written.")
            case _:
                what = "it is no friction or spring of a joint."
                remedy = "Springs of joints are written as Potential(k * q**2 / 2)."
                self._cannot(effort_name(effort), what, remedy)

    def _cannot(self, where: str, what: str, remedy: str) -> None:
        self.cannot.append(Mistake(where, what, remedy))

    def _number(self, expression: sympy.Expr) -> sympy.Expr:
        return self._chains.numbers(sympy.sympify(expression))

    def _take_viscous(self, effort: Viscous) -> None:
        coefficient, found = self._number(effort.coefficient), self._rate_in(effort.velocity)
        if is_zero(coefficient):
            return
        if found is None or coefficient.free_symbols:
            self._no_joint_rate(effort)
            return
        c, factor = found
        self.joints[c].damping += float(coefficient) * (factor / self._factors[c]) ** 2

    def _take_coulomb(self, effort: Coulomb) -> None:
        strength, found = self._number(effort.strength), self._rate_in(effort.velocity)
        smoothing = self._number(effort.smoothing)
        if is_zero(strength):
            return
        if found is None or strength.free_symbols or smoothing.free_symbols:
            self._no_joint_rate(effort)
            return
        c, factor = found
        own = abs(factor) / self._factors[c]
        smoothed = float(smoothing) / own
        if abs(smoothed - SMOOTHING) > SAME * SMOOTHING:
            what = f"it is smoothed by {smoothed:g}, and that of files by {SMOOTHING:g}."
            self._cannot(effort_name(effort), what, f"Give it smoothing={SMOOTHING * own:g}.")
            return
        self.joints[c].friction += float(strength) * own

    def _no_joint_rate(self, effort: Effort) -> None:
        what = "it is not that of one joint with a constant coefficient."
        self._cannot(effort_name(effort), what, "Take the rate of a coordinate, as rate(q).")

    def _rate_in(self, velocity: sympy.Expr) -> tuple[Coordinate, float] | None:
        """Return the coordinate whose rate a velocity is, and the constant factor of it."""
        value = self._number(velocity)
        for c in self._factors:
            if isinstance(c, Coordinate):
                factor = sympy.simplify(sympy.diff(value, rate(c)))
                alone = not factor.free_symbols and not is_zero(factor)
                if alone and is_zero(sympy.simplify(value - factor * rate(c))):
                    return c, float(factor)
        return None

    def _take_potential(self, effort: Potential) -> None:
        """Take a sum of k_i (q_i - r_i)^2 / 2 as springs."""
        value = self._number(effort.energy)
        found: dict[Coordinate, tuple[float, float]] = {}
        for symbol in sorted(value.free_symbols, key=str):
            slope = sympy.diff(value, symbol)
            bend = sympy.simplify(sympy.diff(slope, symbol))
            at_zero = sympy.simplify(slope - bend * symbol)
            linear = not bend.free_symbols and not at_zero.free_symbols
            if not isinstance(symbol, Coordinate) or not linear or not bend > 0:
                what = f"its energy {effort.energy} is not that of springs of joints."
                self._cannot("potential", what, "Write k * (q - q_0)**2 / 2 with k > 0.")
                return
            found[symbol] = float(bend), -float(at_zero / bend)
        for c, (stiffness, rest) in found.items():
            load, factor = self.joints[c], self._factors[c]
            before, own = load.stiffness, stiffness / factor**2
            load.stiffness += own
            load.rest = (before * load.rest + own * rest * factor) / load.stiffness
