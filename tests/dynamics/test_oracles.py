"""Laws of mechanics over every registered system and every machine of ``tests.machines``.

Each law says in a predicate which machines it holds for; a new machine is tested on arrival.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from math import pi
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation as Turn

import kinolab.systems
from kinolab.dynamics import (
    Attitude,
    Body,
    Coordinate,
    Coulomb,
    Drive,
    Model,
    Rope,
    SlidingFriction,
    System,
    Viscous,
    Wrench,
    length,
    move,
    rate,
)
from kinolab.dynamics.lagrange import equations as equations_module
from kinolab.dynamics.language.constraints import PositionConstraint, VelocityConstraint
from kinolab.dynamics.language.frames import Orientation, Rotation, Translation, time_derivative
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.symbols.symbols import Acceleration, TurnAcceleration
from kinolab.errors import SingularError
from tests import registered
from tests.dynamics.machines import knife_edge
from tests.dynamics.machines import snakeboard as snakeboard_by_turning
from tests.machines import MACHINES, four_bar, trident_snake, wheeled_hull

Array = NDArray[np.float64]


def plant(name: str) -> System:
    """Return a registered machine without its controller: laws of mechanics speak of its inputs."""
    return registered.MAKERS[name]().with_feedback(None)


MAKERS: dict[str, Callable[[], System]] = dict(MACHINES)
MAKERS |= {name: partial(plant, name) for name in registered.NAMES}

# Where a chart ends: the snakeboard's with parallel wheels, and heading along y; the bicycle's
# where it lies on its side, which takes a second unless it rides; the parallel robot's where its
# forearms line up.
INSIDE = {
    "five_bar": {
        **{"a_l": 0.2, "a_r": -0.1, "f_l": -0.1, "f_r": 0.1},
        **{"a_l_dot": 0.3, "a_r_dot": -0.2},
    },
    "loose_snakeboard": {
        **{"th": 0.3, "phi_b": 0.5, "phi_f": -0.4},
        **{"phi_b_dot": 0.1, "phi_f_dot": 0.1},
    },
    "whipple": {"phi": 0.1, "theta": 0.0, "delta": -0.05, "theta_R_dot": 17.0},
}
GENTLE = {
    "five_bar": 0.1,
    "loose_snakeboard": 1e-3,
    "whipple": 0.02,
}  # share of the limits; light wheels turn by 150 rad/s^2 else, and light arms by 5

# Machines whose one mass has no extent.
POINT_MASSES = {"motorcycle"}

# What takes away drag that is quadratic in the velocity.
LINEAR = {"submarine": {"d_uu": 0.0, "d_vv": 0.0, "d_qq": 0.0}}


@cache
def system(name: str) -> System:
    return MAKERS[name]()


@cache
def model(name: str) -> Model:
    return system(name).model()


def holds_for(kind: Callable[[System], bool]) -> pytest.MarkDecorator:
    """Run a test for every machine of a kind."""
    return pytest.mark.parametrize("name", [name for name in MAKERS if kind(system(name))])


# Kinds of machines


def everything(_: System) -> bool:
    return True


def massive(machine: System) -> bool:
    """Something resists acceleration, so there are energies and forces."""
    return any(body.mass != 0 or any(body.inertia) for body in machine.bodies)


def constrained(machine: System) -> bool:
    return bool(machine.constraints)


def smooth_in_velocity(machine: System) -> bool:
    """Forces are polynomials of degree 2 in the velocities: no dry friction, nothing kinematic."""
    dry = Coulomb | SlidingFriction
    return massive(machine) and not any(isinstance(e, dry) for e in machine.efforts)


def smooth(machine: System) -> bool:
    """No rope goes slack or taut from a random state, which is a kink."""
    return not any(isinstance(e, Rope) for e in machine.efforts)


def second_order(machine: System) -> bool:
    """No force depends on a velocity at all."""
    resisting = (Viscous, Coulomb, Rope, SlidingFriction, Wrench)
    return massive(machine) and not any(isinstance(e, resisting) for e in machine.efforts)


def without_a_place(machine: System) -> bool:
    """Every body hangs from one moving root, and gravity cannot tell where that is."""
    return root_of(machine) is not None


def root_of(machine: System) -> tuple[tuple[Any, ...], Any] | None:
    """The coordinates of the root's origin and its turn about z, or its attitude."""
    starts = {body.frame.motions[:2] for body in machine.bodies}
    firsts = {start[0] for start in starts if start}
    if len(firsts) == 1 and isinstance(first := next(iter(firsts)), Orientation):
        return (), first.attitude
    if len(starts) != 1 or len(next(iter(starts))) < 2:
        return None
    first, second = next(iter(starts))
    place = tuple(c for c in getattr(first, "by", ()) if isinstance(c, Coordinate))
    if not isinstance(first, Translation) or len(place) < 2:
        return None
    if isinstance(second, Orientation):
        return place, second.attitude
    level = machine.gravity is None or machine.gravity.down[:2] == (0, 0)
    if isinstance(second, Rotation) and second.axis == "z" and level:
        return place, second.angle
    return None


# States and runs


def inputs(name: str, share: float = 0.2) -> Array:
    """Steady inputs at a share of their limits, a rope's tension in the middle of them."""
    bounds, rng = model(name).control_bounds, np.random.default_rng(1)
    middle, half = bounds.mean(axis=1), np.ptp(bounds, axis=1) / 2
    made: Array = middle + GENTLE.get(name, share) * half * rng.uniform(-1, 1, len(half))
    return made


@cache
def gaps(name: str) -> Callable[[Array], Array]:
    """h(q) of the constraints of position, from their own expressions."""
    machine = system(name)
    held = [c.position for c in machine.constraints if isinstance(c, PositionConstraint)]
    values = {p: machine.parameter_values[p.name] for p in machine.parameters}
    function = sp.lambdify([machine.coordinates], [sp.sympify(h).subs(values) for h in held])
    return lambda q: np.asarray(function(q), dtype=float)


def states(name: str, count: int, speed: float = 0.5) -> list[Array]:
    """Random states within the limits: quaternions are unit, loops closed, constraints kept."""
    rng = np.random.default_rng([len(name), count])
    return [state(name, rng, speed) for _ in range(count)]


def state(name: str, rng: np.random.Generator, speed: float) -> Array:
    machine, made = system(name), model(name)
    q: list[float] = []
    for c in machine.coordinates:
        if isinstance(c, Attitude):
            quaternion = rng.normal(size=4)
            q += list(quaternion / np.linalg.norm(quaternion))
        else:
            lower, upper = max(c.lower, -1.0), min(c.upper, 2.5)
            q.append(rng.uniform(lower + 0.2 * (upper - lower), upper - 0.3 * (upper - lower)))
    x = np.array([*q, *rng.uniform(-speed, speed, made.nx - made.nq)])
    for entry, value in INSIDE.get(name, {}).items():
        x[made.state_names.index(entry)] = value * rng.uniform(0.8, 1.2)
    if any(isinstance(c, PositionConstraint) for c in machine.constraints):
        closed = least_squares(gaps(name), x[: made.nq], xtol=1e-15, ftol=1e-15, gtol=1e-15)
        x[: made.nq] = closed.x
    return made.project(x) if machine.velocities == "all" else x


def velocities(made: Model) -> slice:
    """The entries of a state that are velocities."""
    return slice(made.nq, made.nq + len(made.independent))


def run(made: Model, x: Array, u: Array, times: Sequence[float], rtol: float = 1e-10) -> Array:
    """States at some times by DOP853, shape (times, nx)."""
    solved = solve_ivp(
        lambda _, at: made.f(at, u),
        (0.0, times[-1]),
        x,
        "DOP853",
        t_eval=times,
        rtol=rtol,
        atol=rtol / 10,
    )
    assert solved.success, solved.message
    return np.ascontiguousarray(solved.y.T)


# G1: masses


@holds_for(massive)
def test_the_mass_matrix_is_symmetric_and_positive_definite(name: str) -> None:
    """A point mass resists only the motions that are free; the others are held or driven."""
    for x in states(name, 4):
        M = model(name).mass_matrix(x)
        np.testing.assert_array_equal(M, M.T)
        S = free_motions(name, x) if name in POINT_MASSES else np.eye(len(M))
        assert np.linalg.eigvalsh(S.T @ M @ S)[0] > 0
        assert np.linalg.eigvalsh(M)[0] > -1e-12 * np.abs(M).max()  # rounding


def free_motions(name: str, x: Array) -> Array:
    """S of nu = S v for the velocities v that neither a constraint nor a drive determines."""
    made, part = model(name), velocities(model(name))
    driven = {f"{e.on.name}_dot" for e in system(name).inputs if isinstance(e, Drive)}
    rest = x.copy()
    rest[part] = 0.0
    units = np.eye(made.nx)[part][[n not in driven for n in made.state_names[part]]]
    return np.array([made.velocity(rest + unit) for unit in units]).T


@holds_for(massive)
def test_the_mass_matrix_is_the_hessian_of_the_kinetic_energy(name: str) -> None:
    """T is quadratic in v, so differences over unit steps are exact; nu = S v maps M to v."""
    made = model(name)
    part = velocities(made)
    for x in states(name, 3):
        rest = x.copy()
        rest[part] = 0.0
        units = np.eye(made.nx)[part]

        def kinetic(step: Array, at: Array = rest) -> float:
            return float(made.energy(at + step)[0])

        hessian = np.array(
            [[kinetic(a + b) - kinetic(a) - kinetic(b) for b in units] for a in units]
        )
        S = np.array([made.velocity(rest + unit) for unit in units]).T
        expected = S.T @ made.mass_matrix(x) @ S
        # Rounding of T at unit velocities, a few units in the 16th digit.
        np.testing.assert_allclose(hessian, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


# G2: energy


@holds_for(massive)
def test_energy_grows_by_the_work_of_friction_wrenches_and_drives(name: str) -> None:
    """Forces of constraints do none; the error is the integrator's, most at the kinks of ropes."""
    made, u = model(name), inputs(name)
    (x,) = states(name, 1)

    def rates(_: float, both: Array) -> Array:
        return np.append(made.f(both[:-1], u), made.power(both[:-1], u))

    solved = solve_ivp(rates, (0, 1), np.append(x, 0.0), "DOP853", rtol=1e-12, atol=1e-13)
    assert solved.success
    energies = np.array(made.energy(np.ascontiguousarray(solved.y[:-1].T)))
    change = energies.sum(axis=0) - energies[:, 0].sum()
    size = 1.0 + np.ptp(energies[0])
    assert np.abs(change - solved.y[-1]).max() < 1e-9 * size  # [J]


@holds_for(second_order)
def test_without_inputs_no_power_is_spent(name: str) -> None:
    if any(isinstance(entry, Drive) for entry in system(name).inputs):
        pytest.skip("a drive at 0 holds its coordinate with a force that works")
    for x in states(name, 3):
        assert model(name).power(x) == pytest.approx(0.0, abs=1e-12)  # [W]


# G3: velocity terms


@holds_for(smooth_in_velocity)
def test_velocity_terms_are_quadratic_and_linear(name: str) -> None:
    """Even in v: rest plus c(q, v), so that c(q, 2 v) = 4 c(q, v). Odd: drag, 2 v gives twice."""
    made, u = model(name), inputs(name)
    part = velocities(made)

    def at(x: Array, share: float) -> Array:
        moved = x.copy()
        moved[part] *= share
        return made.f(moved, u, **LINEAR.get(name, {}))[part]

    for x in states(name, 3):
        rest, once, back = at(x, 0), at(x, 1), at(x, -1)
        twice, far_back = at(x, 2), at(x, -2)
        size = 1e-10 * (1 + np.abs([once, twice]).max())  # condition of M, at most 1e4
        even, far_even = (once + back) / 2 - rest, (twice + far_back) / 2 - rest
        np.testing.assert_allclose(far_even, 4 * even, rtol=0, atol=size)
        odd, far_odd = (once - back) / 2, (twice - far_back) / 2
        np.testing.assert_allclose(far_odd, 2 * odd, rtol=0, atol=size)
        if second_order(system(name)):
            np.testing.assert_allclose(odd, 0.0, atol=size)


# G4: constraints


def broken(name: str, x: Array, u: Array) -> Array:
    """w(q) nu of every constraint, then h(q), from the constraints' own expressions."""
    machine = system(name)
    numbers = values_of(name, x, u)
    stated = [held_velocity(c) for c in machine.constraints]
    stated += [c.position for c in machine.constraints if isinstance(c, PositionConstraint)]
    return np.array([float(sp.sympify(e).xreplace(numbers)) for e in stated])


def values_of(name: str, x: Array, u: Array) -> dict[Any, float]:
    """The number of every symbol of a machine at a state."""
    machine, made = system(name), model(name)
    named = dict(zip(made.coordinate_names, x, strict=False))
    named |= dict(zip(made.rate_names, made.velocity(x, u), strict=True))
    named |= dict(zip(made.control_names, u, strict=True)) | machine.parameter_values
    named |= dict(
        zip(made.state_names[velocities(made).stop :], x[velocities(made).stop :], strict=True)
    )
    return {symbol: named[symbol.name] for symbol in symbols_of(machine)}


def symbols_of(machine: System) -> list[Any]:
    found: list[Any] = list(machine.parameters)
    for c in machine.coordinates:
        found += [*c.quaternion, *c.turn_rate] if isinstance(c, Attitude) else [c, rate(c)]
    return [*found, *(e.symbol for e in machine.inputs), *(s.symbol for s in machine.states)]


@holds_for(constrained)
def test_constraints_hold_along_a_run(name: str) -> None:
    """Velocities of the reduced form by construction; what is integrated drifts with the error."""
    made, u = model(name), inputs(name)
    (x,) = states(name, 1)
    path = run(made, x, u, np.linspace(0, 1, 9).tolist())
    residuals = np.array([broken(name, at, u) for at in path])
    np.testing.assert_allclose(made.constraint_residual(path, u), residuals, atol=1e-12)
    integrated = any(isinstance(c, PositionConstraint) for c in system(name).constraints)
    # [m/s], [m]: rounding, or 100 times the solver's rtol of motions of about 1 m
    assert np.abs(residuals).max() < (1e-8 if integrated else 1e-12)
    assert np.abs(path[-1] - path[0]).max() > 1e-3  # it moves at all


# G5: invariance


def moved_rigidly(name: str, x: Array, turn: Turn, shift: Array, u: Array) -> Array:
    """A state whose bodies are all turned about the world's origin and shifted."""
    root = root_of(system(name))
    assert root is not None
    made, (place, heading) = model(name), root
    entry = made.coordinate_names.index
    out, nu = x.copy(), made.velocity(x, u).copy()
    if place:
        at = np.zeros(3)
        at[: len(place)] = x[[entry(c.name) for c in place]]
        speed = np.zeros(3)
        speed[: len(place)] = nu[[made.rate_names.index(f"{c.name}_dot") for c in place]]
        for k, c in enumerate(place):
            out[entry(c.name)] = (turn.apply(at) + shift)[k]
            nu[made.rate_names.index(f"{c.name}_dot")] = turn.apply(speed)[k]
    if isinstance(heading, Attitude):
        first = entry(f"{heading.name}_x")
        out[first : first + 4] = (turn * Turn.from_quat(x[first : first + 4])).as_quat()
    else:
        out[entry(heading.name)] += turn.as_rotvec()[2]
    out[velocities(made)] = nu[list(made.independent)]
    return out


@holds_for(without_a_place)
def test_a_machine_moved_and_turned_moves_the_same_way(name: str) -> None:
    """No machine of this kind knows where it is, nor its heading about the direction of gravity."""
    made, u, field = model(name), inputs(name), system(name).gravity
    axis = np.array(field.down if field else (0.0, 0.0, 1.0))
    (x,) = states(name, 1)
    place = (root_of(system(name)) or ((), 0))[0]
    shift = np.array([3.0, -2.0, 0.7 if len(place) == 3 else 0.0]) if place else np.zeros(3)
    turn = Turn.from_rotvec(0.4 * axis)
    other = moved_rigidly(name, x, turn, shift, u)
    poses = [made.frames(run(made, at, u, [0.5])[0]).reshape(-1, 3, 4) for at in (x, other)]
    G = turn.as_matrix()
    np.testing.assert_allclose(poses[1][:, :, :3], G @ poses[0][:, :, :3], atol=1e-8)
    expected = poses[0][:, :, 3] @ G.T + shift
    np.testing.assert_allclose(poses[1][:, :, 3], expected, atol=1e-8)  # [m], 100 times rtol


# G6: derivatives, inverse dynamics


@holds_for(everything)
def test_the_jacobian_is_the_limit_of_central_differences(name: str) -> None:
    made, u, h = model(name), inputs(name), 1e-3
    for x in states(name, 2):
        at = np.concatenate([x, u])

        def f(both: Array) -> Array:
            return made.f(both[: made.nx], both[made.nx :])

        def slope(step: Array, at: Array = at) -> Array:
            near, far = ((f(at + s * step) - f(at - s * step)) / (2 * s) for s in (h, 2 * h))
            return near + (near - far) / 3  # Richardson: the error is O(h^4)

        expected = np.array([slope(unit) for unit in np.eye(len(at))]).T
        A, B = made.jacobian(x, u)
        # h^4 times a fifth derivative of up to 1e5 times the first, where dry friction is steep
        atol = 1e-6 * (1 + np.abs(expected).max())
        np.testing.assert_allclose(np.hstack([A, B]), expected, rtol=1e-6, atol=atol)


def held_velocity(constraint: VelocityConstraint | PositionConstraint) -> Any:
    if isinstance(constraint, VelocityConstraint):
        return constraint.velocity
    return time_derivative(constraint.position)


def accelerations(name: str, x: Array, u: Array) -> dict[Any, float]:
    """Every acceleration: the states' from f, the others from d/dt (w nu) = 0 by SymPy."""
    machine, made = system(name), model(name)
    numbers = values_of(name, x, u)
    unknown: list[Any] = []
    for c in machine.coordinates:
        rates_ = c.turn_rate if isinstance(c, Attitude) else [rate(c)]
        unknown += [
            TurnAcceleration(r) if isinstance(c, Attitude) else Acceleration(c) for r in rates_
        ]
    speeds = [s for s in symbols_of(machine) if s.name in made.rate_names]
    found = dict(zip(made.independent, made.f(x, u)[velocities(made)], strict=True))
    rows, right = [], []
    for constraint in machine.constraints:
        stated = held_velocity(constraint)
        slopes = np.array([float(sp.diff(stated, s).xreplace(numbers)) for s in speeds])
        rows.append(slopes)
        right.append(-float(time_derivative(stated).xreplace(numbers)))
    missing = [i for i in range(len(unknown)) if i not in found]
    if missing:
        A = np.array(rows)
        known = np.array([found.get(i, 0.0) for i in range(len(unknown))])
        solved = np.linalg.lstsq(A[:, missing], np.array(right) - A @ known, rcond=None)[0]
        found |= dict(zip(missing, solved, strict=True))
    return {symbol: found[i] for i, symbol in enumerate(unknown)}


DERIVED_LONGEST = {"arm", "marionette"}  # equations of 200 000 operations and more


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in DERIVED_LONGEST else name
        for name in MAKERS
        if massive(system(name))
    ],
)
def test_compiled_motions_satisfy_the_equations_that_sympy_derives(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two derivations of one machine: Newton-Euler on a tape, Lagrange by SymPy; lambda is free."""
    monkeypatch.setattr(equations_module, "SIMPLIFICATION_SECONDS", 0.5)
    made, u = model(name), inputs(name)
    equations = made.equations()
    count = len(system(name).constraints)
    multipliers = sp.symbols(f"lambda_1:{count + 1}", real=True)
    sides = [e.lhs - e.rhs for e in (*equations.balance, *equations.reduced, *equations.further)]
    free = set().union(*(e.free_symbols for e in sides)) - {*multipliers}
    known = sorted(free, key=str)
    evaluate = sp.lambdify([*known, *multipliers], sides, cse=True)
    (x,) = states(name, 1)
    for at in run(made, x, u, [0.0, 0.15, 0.3]):
        numbers = values_of(name, at, u) | accelerations(name, at, u)
        f = dict(zip(made.state_names, made.f(at, u), strict=True))
        numbers |= {sp.Symbol(f"{s.name}_dot", real=True): f[s.name] for s in system(name).states}
        values = [numbers[symbol] for symbol in known]
        gap = np.array(evaluate(*values, *np.zeros(count)), dtype=float)
        scale = 1 + max(abs(value) for value in numbers.values())
        if multipliers:
            A = np.array([evaluate(*values, *unit) for unit in np.eye(count)]).T - gap[:, None]
            solved = np.linalg.lstsq(A, -gap, rcond=None)[0]
            gap = np.array(evaluate(*values, *solved), dtype=float)
        assert np.abs(gap).max() < 1e-9 * scale  # [N] or [N m], relative to what is added up


# Reduced and multiplier form


def by_multipliers(machine: System) -> System:
    return System(
        machine.name,
        bodies=machine.bodies,
        constraints=machine.constraints,
        inputs=machine.inputs,
        efforts=machine.efforts,
        gravity=machine.gravity,
        velocities="all",
    )


STARTS: dict[str, tuple[Callable[[], System], dict[str, float], dict[str, float]]] = {
    "loose_snakeboard": (
        snakeboard_by_turning,
        {"phi_b": 0.5, "phi_f": -0.5, "psi_dot": 1.0, "th_dot": 0.3},
        {"tau_psi": 0.01},
    ),
    "four_bar": (four_bar, {"a": -1.0}, {"motor": 0.5}),
    "knife_edge": (knife_edge, {"x_dot": 0.5, "th_dot": 0.05}, {}),
}


def closed_from(q: Array) -> Array:
    """Close the four-bar's loop with its crank held, from the elbow-up side."""

    def gap(others: Array) -> Array:
        return gaps("four_bar")(np.array([q[0], *others]))

    found = least_squares(gap, [2.0, 1.0], xtol=1e-15, ftol=1e-15)
    return np.array([q[0], *found.x])


@pytest.mark.parametrize("name", STARTS)
def test_the_reduced_form_is_the_multiplier_form_for_twenty_seconds(name: str) -> None:
    """Two formulations of one motion; both are integrated to 1e-12."""
    make, begin, push = STARTS[name]
    machine = make()
    reduced, full = machine.model(), by_multipliers(machine).model()
    u = np.array([push.get(n, 0.0) for n in reduced.control_names])
    x = np.array([begin.get(n, 0.0) for n in reduced.state_names])
    if name == "four_bar":
        x[:3] = closed_from(x[:3])
    whole = np.concatenate([x[: reduced.nq], reduced.velocity(x, u)])
    times = np.linspace(0, 20, 21).tolist()
    first = run(reduced, x, u, times, rtol=1e-12)
    second = run(full, whole, u, times, rtol=1e-12)
    speeds = reduced.velocity(first, u)
    expected = np.hstack([first[:, : reduced.nq], speeds])
    scale = np.maximum(1.0, np.abs(expected).max(axis=0))
    assert np.abs((second - expected) / scale).max() < 1e-8
    assert np.ptp(expected, axis=0).max() > 0.5  # [m] or [rad]: it went somewhere


def test_a_repeated_constraint_leaves_the_motion_as_it_is() -> None:
    """The same loop, with and without a third row that repeats the first."""
    reduced, full = model("four_bar"), model("four_bar_by_multipliers")
    assert full.redundant == ("loop x again",)
    for x in states("four_bar_by_multipliers", 3):
        chosen = np.array([*x[:3], x[3]])
        np.testing.assert_allclose(reduced.velocity(chosen), x[3:], atol=1e-9)
        f = full.f(x, [0.7])
        np.testing.assert_allclose(f[3], reduced.f(chosen, [0.7])[3], rtol=1e-8)


def test_a_rope_pulls_with_the_weights_share_and_the_centripetal_force() -> None:
    """T = m (g cos a + l a_dot^2) + F sin a: the multiplier of the rope, with its sign."""
    made, a, spin, push = model("rope_pendulum"), 0.6, 1.7, 2.0
    x = [np.sin(a), -np.cos(a), spin * np.cos(a), spin * np.sin(a)]
    tension = 1.5 * (9.81 * np.cos(a) + spin**2) + push * np.sin(a)
    assert made.constraint_forces(x, [push])[0] == pytest.approx(-tension, rel=1e-7)
    assert made.requirements(x, [push])[0] == pytest.approx(tension, rel=1e-7)


# Steps


ORDERS = {"euler": 1, "rosenbrock": 2, "rk4": 4}
STEPS = {"euler": 400, "rosenbrock": 100, "rk4": 20}


@holds_for(smooth)
@pytest.mark.parametrize("method", ORDERS)
def test_a_step_has_its_order_and_keeps_to_the_constraints(name: str, method: str) -> None:
    """Halving the step divides the error by 2^order; projecting does not lower it."""
    made, u = model(name), inputs(name)
    (x,) = states(name, 1)
    end = 0.2
    exact = run(made, x, u, [end], rtol=1e-13)[0]

    def error(count: int) -> float:
        at = made.steps(x, np.tile(u, (count, 1)), np.full(count, end / count), method=method)[-1]
        check_on_constraints(name, at)
        return float(np.abs(at - exact).max())

    # Dry friction turns within 0.1 m/s / 20 m/s^2 = 5 ms, which several steps must see.
    dry = any(isinstance(effort, Coulomb | SlidingFriction) for effort in system(name).efforts)
    count = STEPS[method] * (16 if dry else 1)
    coarse, fine = error(count), error(2 * count)
    if fine < 1e-12:
        assert coarse < 1e-10  # exact to rounding: the motion is a polynomial of this degree
    else:
        assert np.log2(coarse / fine) > ORDERS[method] - 0.25


def check_on_constraints(name: str, x: Array) -> None:
    made = model(name)
    for c in system(name).coordinates:
        if isinstance(c, Attitude):
            first = made.coordinate_names.index(f"{c.name}_x")
            assert abs(np.linalg.norm(x[first : first + 4]) - 1) < 1e-14
    residual = made.constraint_residual(x, inputs(name))
    assert np.abs(residual).max(initial=0.0) < 1e-12  # [m], [m/s]: rounding


def sledge(*friction: Any) -> Model:
    x = length("x")
    return System(
        "sledge",
        bodies=[Body("block", move(x), mass=1.0)],
        efforts=[effort(rate(x)) for effort in friction],
    ).model()


def slid(made: Model, method: str, first: float = 1.0) -> Array:
    """Velocities over 200 steps of 0.01 s, from a first one in [m/s]."""
    path = [np.array([0.0, first])]
    for _ in range(200):
        path.append(made.step(path[-1], (), 0.01, method=method))
    return np.array(path)[:, 1]


@pytest.mark.parametrize("first", np.linspace(0.9, 1.0, 5))
def test_rosenbrock_comes_to_rest_in_dry_friction_where_rk4_chatters(first: float) -> None:
    """5 N over the default 0.01 m/s on 1 kg: a rate of 500 /s against steps of 0.01 s."""
    made = sledge(lambda v: Coulomb(v, 5.0))
    implicit = slid(made, "rosenbrock", first)
    assert np.abs(implicit[150:]).max() < 1e-12  # [m/s]; it stops after 1 m/s / 5 m/s^2 = 0.2 s
    assert np.abs(slid(made, "rk4", 1.0)[150:]).max() > 1e-3


@pytest.mark.parametrize("course", [0.0, 0.3, pi / 4, 2.5])
def test_a_puck_slides_straight_on_and_stops_after_v_squared_over_2_mu_g(course: float) -> None:
    """In every direction alike: 1 m/s under 5 m/s^2 goes 0.1 m; smoothing adds v eps / (mu g)."""
    x, y, eps = length("x"), length("y"), 1e-4
    puck = Body("puck", move(x, y), mass=2.0)
    rubbing = SlidingFriction((rate(x), rate(y)), 2.0 * 5.0, eps)
    made = System("puck", bodies=[puck], efforts=[rubbing]).model()
    ahead = np.array([np.cos(course), np.sin(course)])
    start = np.concatenate([np.zeros(2), ahead])
    run = solve_ivp(lambda _, s: made.f(s), (0, 0.25), start, "Radau", rtol=1e-9, atol=1e-12)
    assert run.y[:2, -1] == pytest.approx(0.1 * ahead, abs=2 * eps / 5.0)
    assert np.abs(run.y[2:, -1]).max() < 1e-9


@pytest.mark.parametrize("method", ORDERS)
def test_dry_friction_that_a_step_jumps_over_stays_bounded(method: str) -> None:
    """The force is at most 5 N: no method can do worse than reverse within one step's impulse.

    Where the slope of tanh is 0 on both sides a linearly implicit method sees no stiffness.
    """
    v = slid(sledge(lambda v: Coulomb(v, 5.0, 1e-4)), method, 1.0)
    assert np.abs(v[50:]).max() < 5.0 * 0.01  # [m/s]


def test_rosenbrock_damps_stiff_drag_where_rk4_blows_up() -> None:
    made = sledge(lambda v: Viscous(v, 1e4))
    assert np.abs(slid(made, "rosenbrock")[-1]) < 1e-6  # [m/s]
    with pytest.raises(SingularError, match="not finite"):
        slid(made, "rk4")


# Files


@holds_for(everything)
def test_a_machine_from_a_file_moves_by_the_same_bits(name: str) -> None:
    made = model(name)
    text = machine_to_json(system(name))
    back = machine_from_json(text)
    assert machine_to_json(back) == text
    again, x, u = Model(back), np.array(states(name, 5)), inputs(name)
    assert again.state_names == made.state_names
    assert again.f(x, u).tobytes() == made.f(x, u).tobytes()
    assert again.frames(x).tobytes() == made.frames(x).tobytes()
    for method in ORDERS:
        after = [m.step(x, u, 0.01, method=method).tobytes() for m in (made, again)]
        assert after[0] == after[1]


# Invariants


def test_a_trident_snake_left_alone_keeps_its_energy() -> None:
    made = trident_snake().model()
    x = np.zeros(made.nx)
    for name, value in {
        "phi0": 0.5,
        "phi1": -0.3,
        "phi2": 0.4,
        "th_dot": 0.4,
        "x_dot": 0.3,
    }.items():
        x[made.state_names.index(name)] = value
    path = run(made, x, np.zeros(3), np.linspace(0, 5, 31).tolist(), rtol=1e-12)
    energy = np.array(made.energy(path)).sum(axis=0)
    assert np.abs(energy / energy[0] - 1).max() < 1e-9
    assert np.abs(path[-1] - path[0]).max() > 0.1


def test_a_hull_keeps_its_angular_momentum_whatever_its_wheels_do() -> None:
    """H = R (J omega + I_w rates) about its pivot, from the numbers of its description."""
    made = wheeled_hull().model()
    Iw, offsets = 0.01, np.diag([0.2, 0.3, 0.4])
    J = np.diag([10.0, 12.0, 8.0])
    for i, at in enumerate(offsets):
        spin = np.full(3, 0.6 * Iw)
        spin[i] = Iw
        J += np.diag(spin) + 1.0 * (at @ at * np.eye(3) - np.outer(at, at))

    def momentum(x: Array) -> Array:
        return Turn.from_quat(x[:4]).apply(J @ x[7:10] + Iw * x[10:13])

    x = np.array([0, 0, 0, 1, 0, 0, 0, 0.3, -0.2, 0.1, 400.0, -200.0, 100.0])
    path = run(made, x, np.array([0.1, -0.05, 0.08]), np.linspace(0, 20, 21).tolist(), rtol=1e-12)
    momenta = np.array([momentum(at) for at in path])
    assert np.abs(momenta - momenta[0]).max() < 1e-9 * np.linalg.norm(momenta[0])
    assert np.ptp(path[:, :4], axis=0).max() > 0.5  # it turned


@pytest.mark.parametrize("size", [1e-12, 1e-3, 2.0])
def test_an_euler_step_turns_an_attitude_by_the_exponential(size: float) -> None:
    """Against SciPy's rotations: R+ = R exp(h w), whatever the angle, to rounding."""
    made = kinolab.systems.get("submarine").model()
    random, first = np.random.default_rng(3), made.attitudes["R"]
    x, q, w = np.zeros(made.nx), random.normal(size=4), random.normal(size=3)
    turned = slice(first, first + 4)
    x[turned], h = q / np.linalg.norm(q), size / np.linalg.norm(w)
    for name, value in zip("xyz", w, strict=True):
        x[made.state_names.index(f"R_w{name}")] = value
    reached = made.step(x, (), h, method="euler")[turned]
    expected = Turn.from_quat(x[turned]) * Turn.from_rotvec(h * w)
    assert (Turn.from_quat(reached).inv() * expected).magnitude() < 1e-15
    assert reached @ x[turned] > 0.5  # q and not -q, for knots are joined by straight ways
    np.testing.assert_allclose(np.linalg.norm(reached), 1.0, atol=1e-15)
