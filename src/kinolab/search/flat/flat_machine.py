"""Machines whose velocities the inputs accelerate at will, as their flat outputs see them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array, Integers
from kinolab.problem import PlanningTask
from kinolab.steering.bounded_curvature import ROUNDING
from kinolab.steering.path_motion import LIMIT_FRACTION
from kinolab.steering.plane_curves import CURVATURE_FRACTION

# Outputs: all coordinates; a point of the plane along which it drives; or its pose, if it is a car.
FULL, PLANE, CAR = 0, 1, 2
STEERINGS = 1001  # whose curvatures are known; between them straight lines are off by millionths
SMALL = 0.1  # inputs by which it is seen, of their half ranges
NO_CURVES = np.zeros(1), np.zeros(3), 1.0  # of machines that are no cars
REMEDY = "auto plans for every machine."


class FlatMachine(NamedTuple):
    """A machine by its flat outputs, for compiled kernels.

    Its motion is given by commands: the rates of all outputs, or of one that drives along a curve
    of the plane, its speed and its turn rate, of a car its speed and its steering rate.
    """

    kind: int  # FULL, PLANE or CAR
    first: bool  # whether inputs are velocities, and not what changes these
    held: bool  # whether a law of feedback holds forces for a step
    constant: bool  # whether inputs accelerate it everywhere alike
    inverse: Array  # (nu, nv) inputs, in halves of their ranges, of accelerations, where constant
    entry: Integers  # (axes,) of the state: all coordinates, or x, y, the heading and what steers
    speeds: Integers  # (nv,) of the state: independent velocities
    driven: Integers  # (nu,) of the state's rates, which inputs give: of these, or of its way
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
    curvature: Array  # (STEERINGS,) of a car's way in [1/m], at even steering within its limits
    bottom: float  # of that steering
    top: float
    steering: Array  # (3,) a car's to the right, straight and to the left, along a curve
    radius: float  # of its curve to the left and to the right in [m]


def flat_machine(problem: PlanningTask) -> FlatMachine:
    """Return a machine by its flat outputs.

    Raises:
        InputError: If it is none of those whose inputs accelerate all that can move, or that drive
            along curves at speeds that inputs are.
    """
    kind, model = _kind(problem), problem.model
    first = not model.nv
    entry, mix = _coordinates(problem, kind)
    driven = np.arange(model.nx)[model.speeds] if not first else entry[[0, 3]]
    gains = _gains(problem, driven, int(entry[2]) if first else -1)
    constant = bool(np.ptp(gains, axis=0).max() <= ROUNDING * np.abs(gains).max())
    lower, upper = model.control_bounds.T
    own = entry[: {FULL: len(entry), PLANE: 2, CAR: 3}[kind]]
    curvature, steering, radius = _curves(problem, entry, mix) if kind == CAR else NO_CURVES
    weight, timed = _weights(problem, kind, own, radius)
    base = problem.start.copy()
    base[model.speeds] = 0.0
    return FlatMachine(
        kind=kind,
        first=first,
        held=model.plant is not model,
        constant=constant,
        inverse=np.linalg.inv(gains[0]),
        entry=entry,
        speeds=np.arange(model.nx)[model.speeds].astype(np.int64),
        driven=driven.astype(np.int64),
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
        curvature=curvature,
        bottom=float(problem.bounds[entry[3], 0]) if kind == CAR else 0.0,
        top=float(problem.bounds[entry[3], 1]) if kind == CAR else 1.0,
        steering=steering,
        radius=radius,
    )


def tightened(bounds: Array, fraction: float = LIMIT_FRACTION) -> Array:
    """Return a fraction of the range between limits (n, 2), where both are finite."""
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(bounds).all(axis=1))
    known = np.where(finite[:, None], bounds, 0.0)
    middle, half = known.mean(axis=1), np.ptp(known, axis=1) / 2
    inner = np.stack([middle - fraction * half, middle + fraction * half], axis=1)
    return np.where(finite[:, None], inner, bounds)


def refusal(problem: PlanningTask, why: str) -> InputError:
    """Return the error that says why a machine is none of those that are planned for."""
    what = f"flat_connect does not plan for the machine {problem.machine.name!r}: {why}"
    return InputError([Mistake("[planner] name", what, REMEDY)])


def _kind(problem: PlanningTask) -> int:
    """Return FULL, PLANE or CAR; raise where it is clear that none fits."""
    model, machine, space = problem.model, problem.machine, problem.space
    if machine.modes or model.clocks or machine.closes_loops:
        raise refusal(problem, "it has modes, closed loops, or obstacles that move.")
    if space.spheres or model.nx != model.nq + model.nv:
        raise refusal(problem, "it has attitudes or states beside coordinates and velocities.")
    if not problem.rests(problem.start):
        raise refusal(problem, "it does not start at rest.")
    flat, steers = machine.flat, model.nv in (0, 2) and model.nu == 2
    if flat is not None and len(flat.steered) == 1 and steers:
        return CAR
    if model.nu != model.nv:
        what = f"{model.nu} inputs do not accelerate {model.nv} independent velocities at will."
        raise refusal(problem, what)
    if model.velocity_names == model.rate_names:
        return FULL
    if flat is None or not flat.plane_curves or flat.steered or model.nv != 2:
        raise refusal(problem, "it neither moves freely nor drives along curves of the plane.")
    return PLANE


def _coordinates(problem: PlanningTask, kind: int) -> tuple[Integers, Array]:
    """Return the entries of the outputs' coordinates, and velocities (nv, nv) of commands."""
    model, flat = problem.model, problem.machine.flat
    if kind == FULL or flat is None:
        return np.arange(model.nq, dtype=np.int64), np.eye(model.nq)
    entry = np.array([model.coordinate_names.index(name) for name in flat.coordinates], np.int64)
    if not model.nv:
        return entry, np.eye(2)
    x = np.tile(problem.start, (2, 1))
    x[:, entry[2:]] = 0.0
    x[:, model.speeds] = np.eye(2)
    names = [model.rate_names.index(f"{name}_dot") for name in flat.coordinates]
    forward, aside, *_, turn = model.velocity(x)[:, names].T
    if np.abs(aside).max() > ROUNDING * np.abs(forward).max():
        raise refusal(problem, "it slips sideways.")
    return entry, np.linalg.inv(np.stack([forward, turn]))


def _curves(problem: PlanningTask, entry: Integers, mix: Array) -> tuple[Array, Array, float]:
    """Return curvatures at even steering of a car, its steering along curves, and their radius.

    Raises:
        InputError: If it slips, or its way depends on its steering otherwise than by its curvature.
    """
    model, row = problem.model, int(entry[3])
    low, high = problem.bounds[row]
    if not np.isfinite([low, high]).all() or not low < 0.0 < high:
        raise refusal(problem, "its steering has no limits to the left and to the right.")
    angles = np.linspace(low, high, STEERINGS)
    x = np.tile(problem.start, (STEERINGS, 1))
    x[:, entry[2]], x[:, row] = 0.0, angles
    if model.nv:
        x[:, model.speeds] = mix[:, 0]
        names = [model.rate_names.index(f"{model.coordinate_names[k]}_dot") for k in entry]
        forward, aside, turn, steer = model.velocity(x)[:, names].T
    else:
        held = np.tile(model.control_bounds[:, 1], (STEERINGS, 1))
        forward, aside, turn, steer = model.f(x, held)[:, entry].T
    even = not model.nv or max(np.ptp(forward), np.ptp(steer)) <= ROUNDING * abs(forward[0])
    curvature = turn / forward
    if not even or np.abs(aside).max() > ROUNDING * np.abs(forward).min():
        raise refusal(problem, "it slips sideways, or its speed depends on how it steers.")
    if not (np.diff(curvature) > 0.0).all() or not curvature[0] < 0.0 < curvature[-1]:
        raise refusal(problem, "its curvature does not grow with its steering.")
    sharpest = CURVATURE_FRACTION * min(-curvature[0], curvature[-1])
    sides = np.array([-sharpest, 0.0, sharpest])
    return curvature, np.interp(sides, curvature, angles), float(1.0 / sharpest)


def _gains(problem: PlanningTask, driven: Integers, heading: int) -> Array:
    """Return how half ranges of inputs accelerate the machine at rest, shape (states, nv, nu).

    A law of feedback may be cut off by the limits of forces; small inputs at rest are not.

    Args:
        driven: Entries of the state whose rates inputs give, shape (nv,).
        heading: The entry that is zero for this; negative for none.

    Raises:
        InputError: If accelerations are not affine in the inputs, or these do not give all of them.
    """
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    found = []
    for _ in range(10):  # states in which it is seen what inputs do
        x = problem.sample(generator)
        x[model.speeds] = 0.0
        x[[heading] if heading >= 0 else []] = 0.0
        rows = np.vstack([np.zeros(model.nu), np.eye(model.nu), generator.uniform(-1, 1, model.nu)])
        inputs = middle + SMALL * half * rows
        rates = model.f(np.tile(x, (len(rows), 1)), inputs)[:, driven]
        gain = (rates[1:-1] - rates[0]) / SMALL
        off = np.abs(rates[-1] - rates[0] - SMALL * rows[-1] @ gain).max()
        if not off <= ROUNDING * np.abs(rates).max():
            raise refusal(problem, "its accelerations are not affine in its inputs.")
        if np.linalg.matrix_rank(gain, tol=ROUNDING * np.abs(gain).max()) < model.nu:
            raise refusal(problem, "there are velocities that its inputs do not accelerate.")
        found.append(gain.T)
    return np.array(found)


def _weights(problem: PlanningTask, kind: int, own: Integers, radius: float) -> tuple[Array, bool]:
    """Return the weights of outputs, and whether they make times at full speed of them."""
    if kind == PLANE:
        return np.ones(2), False
    if kind == CAR:
        return np.array([1.0, 1.0, radius]), False
    bounds = np.minimum(np.abs(problem.rate_bounds), np.abs(problem.bounds[problem.model.speeds]))
    fastest = bounds.min(axis=1)
    timed = bool(np.isfinite(fastest).all())
    return 1.0 / (fastest if timed else problem.scales[own]), timed
