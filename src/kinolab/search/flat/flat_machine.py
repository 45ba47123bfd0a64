"""Machines whose velocities the inputs accelerate at will, as their flat outputs see them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array, Integers
from kinolab.problem import PlanningTask
from kinolab.steering.path_motion import LIMIT_FRACTION

FULL, PLANE = 0, 1  # outputs: all coordinates, or a point of the plane along which it drives
RANDOM_STATES = 10  # in which it is seen what inputs do
SMALL = 0.1  # inputs by which it is seen, of their half ranges
ROUNDING = 1e-9  # relative to the largest rate
REMEDY = "auto plans for every machine."


class FlatMachine(NamedTuple):
    """A machine by its flat outputs, for compiled kernels.

    Its motion is given by commands: the rates of all outputs, or of one that drives along a curve
    of the plane, its speed and its turn rate.
    """

    kind: int  # FULL or PLANE
    held: bool  # whether a law of feedback holds forces for a step
    constant: bool  # whether inputs accelerate it everywhere alike
    inverse: Array  # (nu, nv) inputs, in halves of their ranges, of accelerations, where constant
    entry: Integers  # (axes,) of the state: all coordinates, or x, y and the heading
    speeds: Integers  # (nv,) of the state: independent velocities
    mix: Array  # (nv, nv) independent velocities of commands
    unmix: Array  # (nv, nv) commands of independent velocities
    base: Array  # (nx,) a state at rest, for all entries that outputs do not determine
    middle: Array  # (nu,) of the inputs
    half: Array  # (nu,) of their ranges
    lower: Array  # (outputs,) where outputs are sampled
    upper: Array  # (outputs,)
    weight: Array  # (outputs,) in the metric
    timed: bool  # whether that is the time at full speed
    period: Array  # (outputs,) of each, infinite if it has none


def flat_machine(problem: PlanningTask) -> FlatMachine:
    """Return a machine by its flat outputs.

    Raises:
        InputError: If it is none of those whose inputs accelerate all that can move.
    """
    kind = FULL if _has_all_rates(problem) else PLANE
    entry, mix = _coordinates(problem, kind)
    gains = _gains(problem)
    constant = bool(np.ptp(gains, axis=0).max() <= ROUNDING * np.abs(gains).max())
    lower, upper = problem.model.control_bounds.T
    own = entry if kind == FULL else entry[:2]
    weight, timed = _weights(problem, kind, own)
    base = problem.start.copy()
    base[problem.model.speeds] = 0.0
    return FlatMachine(
        kind=kind,
        held=problem.model.plant is not problem.model,
        constant=constant,
        inverse=np.linalg.inv(gains[0]),
        entry=entry,
        speeds=np.arange(problem.model.nx)[problem.model.speeds].astype(np.int64),
        mix=mix,
        unmix=np.asarray(np.linalg.inv(mix)),
        base=base,
        middle=(lower + upper) / 2,
        half=(upper - lower) / 2,
        lower=np.ascontiguousarray(problem.sampling_bounds[own, 0]),
        upper=np.ascontiguousarray(problem.sampling_bounds[own, 1]),
        weight=weight,
        timed=timed,
        period=np.where(problem.circular[own], 2 * np.pi, np.inf),
    )


def tightened(bounds: Array, fraction: float = LIMIT_FRACTION) -> Array:
    """Return a fraction of the range between limits (n, 2), where both are finite."""
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(bounds).all(axis=1))
    known = np.where(finite[:, None], bounds, 0.0)
    middle, half = known.mean(axis=1), np.ptp(known, axis=1) / 2
    inner = np.stack([middle - fraction * half, middle + fraction * half], axis=1)
    return np.where(finite[:, None], inner, bounds)


def _refuse(problem: PlanningTask, why: str) -> InputError:
    what = f"flat_connect does not plan for the machine {problem.machine.name!r}: {why}"
    return InputError([Mistake("[planner] name", what, REMEDY)])


def _has_all_rates(problem: PlanningTask) -> bool:
    """Say whether all rates, and nothing else, are velocities; raise where neither kind fits."""
    model, machine, space = problem.model, problem.machine, problem.space
    if machine.modes or model.clocks or machine.closes_loops:
        raise _refuse(problem, "it has modes, closed loops, or obstacles that move.")
    if space.spheres or model.nx != model.nq + model.nv:
        raise _refuse(problem, "it has attitudes or states beside coordinates and velocities.")
    if not problem.rests(problem.start):
        raise _refuse(problem, "it does not start at rest.")
    if model.nu != model.nv:
        what = f"{model.nu} inputs do not accelerate {model.nv} independent velocities at will."
        raise _refuse(problem, what)
    return model.velocity_names == model.rate_names


def _coordinates(problem: PlanningTask, kind: int) -> tuple[Integers, Array]:
    """Return the entries of the outputs' coordinates, and velocities (nv, nv) of commands."""
    model = problem.model
    if kind == FULL:
        return np.arange(model.nq, dtype=np.int64), np.eye(model.nq)
    flat = problem.machine.flat
    if flat is None or not flat.plane_curves or flat.steered or model.nv != 2:
        raise _refuse(problem, "it neither moves freely nor turns on the spot in the plane.")
    entry = np.array([model.coordinate_names.index(name) for name in flat.coordinates], np.int64)
    x = np.tile(problem.start, (2, 1))
    x[:, entry[2]] = 0.0
    x[:, model.speeds] = np.eye(2)
    names = [model.rate_names.index(f"{name}_dot") for name in flat.coordinates]
    forward, aside, turn = model.velocity(x)[:, names].T
    if np.abs(aside).max() > ROUNDING * np.abs(forward).max():
        raise _refuse(problem, "it slips sideways.")
    return entry, np.linalg.inv(np.stack([forward, turn]))


def _gains(problem: PlanningTask) -> Array:
    """Return how half ranges of inputs accelerate the machine at rest, shape (states, nv, nu).

    A law of feedback may be cut off by the limits of forces; small inputs at rest are not.

    Raises:
        InputError: If accelerations are not affine in the inputs, or these do not give all of them.
    """
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    found = []
    for _ in range(RANDOM_STATES):
        x = problem.sample(generator)
        x[model.speeds] = 0.0
        rows = np.vstack([np.zeros(model.nu), np.eye(model.nu), generator.uniform(-1, 1, model.nu)])
        inputs = middle + SMALL * half * rows
        rates = model.f(np.tile(x, (len(rows), 1)), inputs)[:, model.speeds]
        gain = (rates[1:-1] - rates[0]) / SMALL
        off = np.abs(rates[-1] - rates[0] - SMALL * rows[-1] @ gain).max()
        if not off <= ROUNDING * np.abs(rates).max():
            raise _refuse(problem, "its accelerations are not affine in its inputs.")
        if np.linalg.matrix_rank(gain, tol=ROUNDING * np.abs(gain).max()) < model.nv:
            raise _refuse(problem, "there are velocities that its inputs do not accelerate.")
        found.append(gain.T)
    return np.array(found)


def _weights(problem: PlanningTask, kind: int, own: Integers) -> tuple[Array, bool]:
    """Return the weights of outputs, and whether they make times at full speed of them."""
    if kind == PLANE:
        return np.ones(2), False
    bounds = np.minimum(np.abs(problem.rate_bounds), np.abs(problem.bounds[problem.model.speeds]))
    fastest = bounds.min(axis=1)
    timed = bool(np.isfinite(fastest).all())
    return 1.0 / (fastest if timed else problem.scales[own]), timed
