"""The derived vehicle that steers by skidding against a hand derivation, and slow against fast.

Sides are chained: what the oracle's two wheels of a side would do by themselves, with half of the
side's torque each, the chain averages.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab
from kinolab import systems
from kinolab.analyze.execute.conditions import Conditions
from kinolab.dynamics import LeastDissipation, least_dissipation
from tests.conftest import Solved
from tests.executions import execute
from tests.oracles import slip_steered as oracle
from tests.oracles.slip_steered import SkidVehicle, sides

Array = NDArray[np.float64]

EPS = 0.01  # [m/s] smoothing of the friction
DRAG = 2.5  # [N m s/rad] of the motors of a side
PLAIN = SkidVehicle()
ODD = SkidVehicle(m=62.0, I_z=4.1, I_w=0.08, c=0.27, r=0.11, ahead=0.07, left=-0.05, mu=(0.55,) * 4)
SNAP = oracle.snap_offset(PLAIN)  # [m] ahead, from where on the front axle holds
PLACES = ("x", "y", "psi", "v_x", "v_y", "psi_dot", "phi_l_dot", "phi_r_dot")


@pytest.fixture(scope="module")
def model() -> Any:
    return systems.get("slip_steered").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """Random states as ``PLACES`` has them, shape (50, 8), and torques in [N m], shape (50, 2)."""
    random = np.random.default_rng(2006)
    x = random.uniform(-1, 1, (50, 8)) * np.array([3, 3, 3, 1, 0.5, 2, 9, 9])
    return x, random.uniform(-30, 30, (50, 2))


def parameters(vehicle: SkidVehicle, eps: float = EPS) -> dict[str, float]:
    """The machine's parameters; its axles are equally far from the middle."""
    names = ("m", "I_z", "I_w", "a", "c", "r", "ahead", "left", "g")
    own = {name: getattr(vehicle, name) for name in names}
    return own | {"mu": vehicle.mu[0], "eps": eps, "c_w": DRAG}


def ordered(model: Any, x: Array) -> Array:
    """A state as the model wants it; how far the wheels have turned does not matter."""
    known = dict(zip(PLACES, x, strict=True)) | {"phi_l": 0.7, "phi_r": -2.0}
    known["x_dot"], known["y_dot"] = facing(x[2]) @ x[3:5]
    return np.array([known[name] for name in model.state_names])


def facing(psi: float) -> Array:
    """What turns body axes into the world's, shape (2, 2)."""
    c, s = np.cos(psi), np.sin(psi)
    return np.array([[c, -s], [s, c]])


def chained(x: Array) -> Array:
    """The same in the oracle's order, with a rate per wheel."""
    return np.concatenate([x[:6], sides(*x[6:])])


def derivative(model: Any, x: Array, u: Array, vehicle: SkidVehicle, eps: float = EPS) -> Array:
    """Return the model's x_dot as ``PLACES`` has it; v = R V, so v_dot = R (V_dot + omega x V)."""
    slopes = model.f(ordered(model, x), u, **parameters(vehicle, eps))
    found = dict(zip(model.state_names, slopes, strict=True))
    acceleration = facing(x[2]).T @ [found["x_dot"], found["y_dot"]]
    found["v_x"], found["v_y"] = acceleration + x[5] * np.array([x[4], -x[3]])
    return np.array([found[name] for name in PLACES])


def expected(x: Array, u: Array, vehicle: SkidVehicle) -> Array:
    """Return the oracle's, the two wheels of a side being averaged."""
    torques = (u - DRAG * x[6:]) / 2
    free = oracle.derivative(chained(x), sides(*torques), vehicle, EPS)
    return np.array([*free[:6], free[[6, 8]].mean(), free[[7, 9]].mean()])


@pytest.mark.parametrize("vehicle", [PLAIN, ODD])
def test_derived_motion_equals_the_hand_derivation(
    model: Any, samples: tuple[Array, Array], vehicle: SkidVehicle
) -> None:
    for x, u in zip(*samples, strict=True):
        wanted = expected(x, u, vehicle)
        found = derivative(model, x, u, vehicle)
        assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize("vehicle", [PLAIN, ODD])
def test_energy_and_power_are_those_of_the_hand_derivation(
    model: Any, samples: tuple[Array, Array], vehicle: SkidVehicle
) -> None:
    for x, u in zip(*samples, strict=True):
        state, whole = ordered(model, x), chained(x)
        kinetic, _ = model.energy(state, **parameters(vehicle))
        assert float(kinetic) == pytest.approx(oracle.kinetic_energy(whole, vehicle), rel=1e-12)
        heat = oracle.friction_heat(whole[3:6], whole[6:], vehicle, EPS) + DRAG * x[6:] @ x[6:]
        power = float(model.power(state, u, **parameters(vehicle)))
        assert power == pytest.approx(u @ x[6:] - heat, abs=1e-10 * (1 + heat))


def pushed(t: float) -> Array:
    """Smooth torques in [N m] that make it turn to both sides, and back."""
    return np.array([6 - 24 * np.sin(3 * t), 6 + 28 * np.sin(3 * t)])


@pytest.mark.parametrize("vehicle", [PLAIN, ODD])
def test_energy_changes_by_the_work_of_the_motors_less_heat(
    model: Any, vehicle: SkidVehicle
) -> None:
    def slope(t: float, both: Array) -> Array:
        x, u = both[:8], pushed(t)
        heat = oracle.friction_heat(x[3:6], sides(*x[6:]), vehicle, EPS)
        power = (u - DRAG * x[6:]) @ x[6:] - heat
        return np.append(derivative(model, x, u, vehicle), [power, heat])

    run = solve_ivp(slope, (0, 2), np.zeros(10), "LSODA", rtol=1e-9, atol=1e-10)
    kinetic = np.array([oracle.kinetic_energy(chained(x), vehicle) for x in run.y[:8].T])
    assert run.y[9, -1] > 20.0  # [J]: it skids
    assert np.abs(kinetic - run.y[8]).max() < 1e-6 * run.y[9, -1]


def test_at_rest_without_torques_it_stays_at_rest(model: Any) -> None:
    at_rest = ordered(model, np.array([1.0, 2.0, 0.3, 0, 0, 0, 0, 0]))
    assert not np.any(model.f(at_rest, np.zeros(2)))


def test_driving_straight_it_rolls(model: Any) -> None:
    """v = r w, and nothing is lost to the ground: equal torques, no load off the middle."""
    u = np.array([10.0, 10.0])
    run = solve_ivp(
        lambda _, x: derivative(model, x, u, PLAIN), (0, 20), np.zeros(8), "Radau", rtol=1e-9
    )
    w = 10.0 / DRAG  # [rad/s]: all torque goes into the motors' own losses
    end = run.y[:, -1]
    assert end[[1, 2, 4, 5]] == pytest.approx(np.zeros(4), abs=1e-9)
    assert end[[3, 6, 7]] == pytest.approx([PLAIN.r * w, w, w], abs=1e-6)
    assert oracle.friction_heat(end[3:6], sides(w, w), PLAIN, EPS) < 1e-6  # [W]


# Least dissipation


def least(vehicle: SkidVehicle, left: float, right: float) -> LeastDissipation:
    machine = systems.get("slip_steered").with_parameters(**parameters(vehicle))
    return least_dissipation(machine, {"phi_l_dot": left, "phi_r_dot": right})


def body_velocity(found: LeastDissipation) -> Array:
    """The velocity in body axes of a vehicle that heads along x."""
    return np.array([found.rates[name] for name in ("x_dot", "y_dot", "psi_dot")])


TURNS = [(2.0, 6.0), (-3.0, 5.0), (4.0, -4.0), (0.0, 5.0)]


@pytest.mark.parametrize("rates", TURNS)
@pytest.mark.parametrize("vehicle", [PLAIN, ODD, SkidVehicle(ahead=SNAP + 0.03)])
def test_least_dissipation_is_that_of_a_grid_and_of_a_linear_program(
    vehicle: SkidVehicle, rates: tuple[float, float]
) -> None:
    found, w = least(vehicle, *rates), sides(*rates)
    V = body_velocity(found)
    assert found.power == pytest.approx(oracle.dissipation(V, w, vehicle), rel=1e-12)
    grid = oracle.least_by_grid(w, vehicle, precision=1e-6)
    assert oracle.dissipation(grid, w, vehicle) == pytest.approx(found.power, rel=1e-5)
    assert pytest.approx(grid, abs=1e-4) == V  # P is flat to the square of it
    low, high = oracle.least_by_polygons(w, vehicle)
    assert low - 1e-6 <= found.power <= high + 1e-6
    assert -1e-9 < found.power - found.bound < 1e-7 * vehicle.grips.sum()  # [W]; the softening


def test_driving_straight_dissipates_nothing() -> None:
    found = least(ODD, 5.0, 5.0)
    assert body_velocity(found) == pytest.approx([5.0 * ODD.r, 0, 0], abs=1e-8)
    assert found.power < 1e-5  # [W] of hundreds in a turn


@pytest.mark.parametrize("rates", TURNS)
def test_a_symmetric_vehicle_turns_about_a_point_between_its_axles(
    rates: tuple[float, float],
) -> None:
    centre = oracle.rotation_centre(body_velocity(least(PLAIN, *rates)))
    assert centre[0] == pytest.approx(0, abs=1e-7)


def test_a_turn_on_the_spot_has_a_closed_form() -> None:
    turn, heat = oracle.turn_on_the_spot(4.0, PLAIN)
    found = least(PLAIN, -4.0, 4.0)
    assert body_velocity(found) == pytest.approx([0, 0, turn], abs=1e-7)
    assert found.power == pytest.approx(heat, rel=1e-7)


@pytest.mark.parametrize("rates", [(2.0, 6.0), (-4.0, 4.0)])
def test_the_front_axle_holds_where_the_load_is_far_enough_ahead(
    rates: tuple[float, float],
) -> None:
    before, after = (SkidVehicle(ahead=SNAP + step) for step in (-0.01, 0.01))
    hold = oracle.axle_twist(sides(*rates), "front", after)
    assert body_velocity(least(after, *rates)) == pytest.approx(hold, abs=1e-6)
    assert np.abs(body_velocity(least(before, *rates)) - hold).max() > 1e-3


def test_a_light_vehicle_moves_as_it_dissipates_least(model: Any) -> None:
    """Wheels held at their rates, loads as they are: V settles within O(inertia) + O(eps)."""
    vehicle, w, errors = SkidVehicle(ahead=0.03), np.array([2.0, 6.0]), []
    wanted = body_velocity(least(vehicle, *w))
    for share in (1e-1, 1e-2):
        light = SkidVehicle(
            m=share * vehicle.m,
            g=vehicle.g / share,
            I_z=share * vehicle.I_z,
            I_w=share * vehicle.I_w,
            ahead=0.03,
        )

        def slope(_: float, x: Array, light: SkidVehicle = light) -> Array:
            moving = derivative(model, x, np.zeros(2), light, eps=1e-4)
            return np.array([0, 0, 0, *moving[3:6], 0, 0])

        start = np.array([0, 0, 0, 0, 0, 0, *w])
        run = solve_ivp(slope, (0, 1), start, "Radau", rtol=1e-8, atol=1e-10)
        errors.append(float(np.abs(run.y[3:6, -1] - wanted).max()))
    assert errors[1] < 1e-3  # [m/s], [rad/s]
    assert errors[1] < errors[0] / 5


# The plan into the loading bay


@pytest.fixture(scope="module")
def parked() -> Solved:
    """The vehicle's plan as users get it, which ends in the middle of its bay."""
    problem = kinolab.load("slip_steered_bay")
    plan = problem.solve()
    assert plan.trajectory is not None, plan.message
    return Solved(problem, plan, plan.trajectory)


@pytest.mark.long
def test_the_plan_ends_in_the_middle_of_the_bay(parked: Solved) -> None:
    assert parked.plan.status == "solved"
    assert parked.problem.goal_excess(parked.trajectory.x[-1]) < 1e-3  # of the tolerances


@pytest.mark.long
@pytest.mark.parametrize("share", [0.8, 1.2])
def test_feedback_brings_it_into_its_bay_with_friction_that_is_a_fifth_off(
    parked: Solved, share: float
) -> None:
    """With noise of 0.2 % of every state's scale, and of 2 % of the torques' range."""
    conditions = Conditions(noise=0.002, disturbance=0.02, built={"mu": share * 0.7})
    assert execute(parked.problem, parked.trajectory, conditions, runs=100).reached >= 95
