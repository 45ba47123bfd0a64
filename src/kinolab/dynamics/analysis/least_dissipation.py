"""Least dissipation: how a machine moves that cannot roll everywhere, so that contacts must slide.

If it moves slowly, inertia does not matter: friction balances, and of all velocities that leave the
given ones as they are, the machine has those at which friction turns the least power into heat,

    minimise P = sum mu_i N_i |s_i(q_dot)|,    s_i: the slip of contact i.

P is convex, but has kinks where a contact holds. So its norms are softened,
|s| ~ sqrt(|s|^2 + eps^2), and eps goes to 0. The forces at the end prove the result: those that
balance and lie within the friction circles bound P from below, for any velocities.

Source: Alexander, Maddocks, On the kinematics of wheeled mobile robots, IJRR 8(5), 1989; Murphey,
Burdick, The power dissipation method and kinematic reducibility of multiple-model robotic systems,
IEEE Trans. Robotics 22(4), 2006; Boyd, Vandenberghe, Convex Optimization, 2004, section 5.9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    dry_frictions,
    tangent_symbols,
)
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.numerics.arrays import Array


@checked
@dataclass(frozen=True)
class LeastDissipation:
    """Velocities of least dissipation, with a proof.

    Attributes:
        rates: The rate of every coordinate in [m/s] or [rad/s], by name, such as ``psi_dot``.
        power: What dry friction turns into heat at these rates, in [W].
        bound: What it cannot fall below at any rates that agree with the given ones, in [W].
    """

    rates: Mapping[str, float]
    power: float
    bound: float


@checked
def least_dissipation(
    system: Mechanism, given: Mapping[Any, float], at: Mapping[Any, float] | None = None
) -> LeastDissipation:
    """Return the velocities at which dry friction dissipates least, while some are given.

    That is how a machine moves that is light or slow, such as a vehicle that skids while motors
    turn its wheels. Friction is that of ``SlidingFriction`` and ``Coulomb``, without smoothing;
    constraints hold; other forces do not count.

    Args:
        system: The machine.
        given: Rates in [m/s] or [rad/s], such as ``{rate(phi): 4.0}`` or ``{"phi_dot": 4.0}``.
        at: Coordinates in [m] or [rad], likewise; those left out are 0.

    Raises:
        InputError: If the machine has no dry friction, if its strength is negative or depends on
            more than coordinates and parameters, or if constraints forbid the given rates.
        UnknownNameError: If a name is no rate, or no coordinate, of the machine.
    """
    rates = tangent_symbols(system)
    q = configuration_symbols(system)
    values = _named(q, at or {})
    place = {symbol: values.get(k, 0.0) for k, symbol in enumerate(q)} | system.substitutions
    slips, grips = _contacts(system, rates, place)
    known, free = _velocities(system, rates, place, _named(rates, given))
    A, p = slips @ free, -slips @ known
    z, forces = _least(A, p, grips)
    names = (symbol.name for symbol in rates)
    return LeastDissipation(
        rates=dict(zip(names, (known + free @ z).tolist(), strict=True)),
        power=float(grips @ np.linalg.norm(A @ z - p, axis=1)),
        bound=float(-(forces * p).sum()),
    )


def _named(symbols: Sequence[sympy.Symbol], given: Mapping[Any, float]) -> dict[int, float]:
    """Return values by their places among symbols; a key is a symbol or its name."""
    names = [symbol.name for symbol in symbols]
    found = {getattr(key, "name", key): float(value) for key, value in given.items()}
    for name in found:
        if name not in names:
            raise UnknownNameError("variable", str(name), known=names)
    return {names.index(name): value for name, value in found.items()}


def _contacts(
    system: Mechanism, rates: Sequence[sympy.Symbol], place: Mapping[sympy.Symbol, float]
) -> tuple[Array, Array]:
    """Return the derivatives of all slips by the rates, shape (n, 2, nt), and mu N, shape (n,)."""
    where = f"system {system.name!r}"
    rubbing = [(slip, strength.subs(place)) for slip, strength in dry_frictions(system)]
    for _, strength in rubbing:
        if not strength.is_number or strength < 0:
            what = f"the strength of a friction is {strength} there."
            remedy = "It must be a number, and not negative, where coordinates are known."
            raise InputError([Mistake(where, what, remedy)])
    rubbing = [(slip, strength) for slip, strength in rubbing if strength > 0]
    if not rubbing:
        what, remedy = "it has no dry friction.", "Give it SlidingFriction or Coulomb."
        raise InputError([Mistake(where, what, remedy)])
    slips = np.stack([_rows(slip, rates, place) for slip, _ in rubbing])
    return slips, np.array([float(strength) for _, strength in rubbing])


def _rows(
    velocities: Sequence[sympy.Expr],
    rates: Sequence[sympy.Symbol],
    place: Mapping[sympy.Symbol, float],
) -> Array:
    """Return the derivatives of velocities by the rates, shape (n, nt)."""
    rows = [[float(v.diff(rate).subs(place)) for rate in rates] for v in velocities]
    return np.array(rows).reshape(-1, len(rates))


def _velocities(
    system: Mechanism,
    rates: Sequence[sympy.Symbol],
    place: Mapping[sympy.Symbol, float],
    given: Mapping[int, float],
) -> tuple[Array, Array]:
    """Return rates (nt,) as given, and a basis (nt, k) of what constraints leave besides."""
    constraints = _rows([c.velocity for c in system.constraints], rates, place)
    rows = np.vstack([constraints, np.eye(len(rates))[list(given)]])
    wanted = np.concatenate([np.zeros(len(constraints)), list(given.values())])
    known = np.linalg.lstsq(rows, wanted, rcond=None)[0]
    # 1e-9 of the given velocities: what constraints may leave of them, rounding only
    slack = 1e-9 * float(np.linalg.norm(wanted))
    if not np.allclose(rows @ known, wanted, rtol=0, atol=slack):
        what = "its constraints forbid the given rates."
        raise InputError([Mistake(f"system {system.name!r}", what)])
    return known, scipy.linalg.null_space(rows)


def _least(A: Array, p: Array, grips: Array) -> tuple[Array, Array]:
    """Minimise sum mu N |A z - p|; return z and balanced forces within the friction circles.

    Args:
        A: Shape (n, 2, k).
        p: Shape (n, 2).
        grips: Shape (n,).
    """
    z, size = np.zeros(A.shape[2]), float(np.abs(p).max()) or 1.0
    # 1e-8 of the largest slip: the last eps
    for eps in size * np.geomspace(1.0, 1e-8, 28):  # from one to the next by about a half
        z = scipy.optimize.root(_slopes, z, (eps, A, p, grips), "lm", jac=True, tol=1e-14).x
    s = A @ z - p
    forces = (grips / np.sqrt((s**2).sum(axis=1) + eps**2))[:, None] * s
    rows = A.reshape(-1, A.shape[2])
    forces -= np.linalg.lstsq(rows.T, rows.T @ forces.ravel(), rcond=None)[0].reshape(-1, 2)
    return z, forces / max(1.0, float((np.linalg.norm(forces, axis=1) / grips).max()))


def _slopes(z: Array, eps: float, A: Array, p: Array, grips: Array) -> tuple[Array, Array]:
    """Return gradient (k,) and Hessian (k, k) of sum mu N sqrt(|A z - p|^2 + eps^2)."""
    s = A @ z - p
    lengths = np.sqrt((s**2).sum(axis=1) + eps**2)
    n = s / lengths[:, None]
    bends = (np.eye(2) - n[:, :, None] * n[:, None, :]) * (grips / lengths)[:, None, None]
    hessian = np.einsum("ijk,ijl,ilm->km", A, bends, A)
    return np.einsum("i,ijk,ij->k", grips, A, n), np.asarray(hessian)
