"""The skidding vehicle's oracle against closed forms, and against itself on a second way."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.oracles.slip_steered import (
    Array,
    SkidVehicle,
    axle_twist,
    body_acceleration,
    derivative,
    dissipation,
    energy_balance,
    friction_heat,
    kinetic_energy,
    least_by_grid,
    least_by_newton,
    least_by_polygons,
    loads,
    loads_of_least_energy,
    rotation_centre,
    sides,
    slip_velocities,
    snap_offset,
    turn_on_the_spot,
)

ODD = SkidVehicle(a=0.3, b=0.2, ahead=0.07, left=-0.05, mu=(0.5, 0.9, 0.6, 0.8))


def test_springs_carry_what_balances_with_the_least_energy() -> None:
    assert loads(ODD) == pytest.approx(loads_of_least_energy(ODD), rel=1e-12)
    assert loads(SkidVehicle()) == pytest.approx(np.full(4, 50 * 9.81 / 4))


def test_loads_ahead_follow_the_lever() -> None:
    """An axle's share is the other's distance to the centre of mass, over the wheelbase."""
    vehicle = SkidVehicle(a=0.3, b=0.2, ahead=0.07)
    weight = vehicle.m * vehicle.g
    assert loads(vehicle)[:2].sum() == pytest.approx(weight * 0.27 / 0.5)


def test_slip_is_the_velocity_of_the_rubber() -> None:
    """Finite motion: where a contact of the body goes, less what the wheel unrolls."""
    V, rates, h = np.array([0.4, -0.1, 0.6]), np.array([3.0, 4.0, -1.0, 2.0]), 1e-6
    turn = np.array([[np.cos(h * V[2]), -np.sin(h * V[2])], [np.sin(h * V[2]), np.cos(h * V[2])]])
    moved = (h * V[:2] + ODD.contacts @ turn.T - ODD.contacts) / h
    moved[:, 0] -= ODD.r * rates
    assert slip_velocities(V, rates, ODD) == pytest.approx(moved, abs=1e-6)


def test_straight_drive_costs_nothing() -> None:
    found = least_by_newton(sides(5.0, 5.0), ODD)
    assert list(found.V) == pytest.approx([0.6, 0, 0], abs=1e-8)
    assert found.P < 1e-5  # [W]; the softening allows eps sum mu N


@pytest.mark.parametrize("seed", range(2))
def test_grid_newton_and_polygons_agree(seed: int) -> None:
    random = np.random.default_rng(seed)
    vehicle = SkidVehicle(
        ahead=random.uniform(-0.2, 0.2), left=random.uniform(-0.1, 0.1), mu=(0.5, 0.6, 0.8, 0.9)
    )
    rates = random.uniform(-8, 8, 4)
    found = least_by_newton(rates, vehicle)
    assert found.gap > -1e-9
    assert found.gap < 2e-8 * vehicle.grips.sum()  # [W]; twice what the softening allows
    assert (np.linalg.norm(found.forces, axis=1) <= vehicle.grips * (1 + 1e-12)).all()
    grid = least_by_grid(rates, vehicle, precision=1e-6)
    assert dissipation(grid, rates, vehicle) == pytest.approx(found.P, rel=1e-5)
    assert grid == pytest.approx(found.V, abs=1e-4)  # P is flat to the square of it
    low, high = least_by_polygons(rates, vehicle)
    assert low - 1e-6 <= found.P <= high + 1e-6


def test_symmetric_vehicle_turns_about_a_point_between_its_axles() -> None:
    for left, right in ((2.0, 6.0), (-3.0, 5.0)):
        V = least_by_newton(sides(left, right), SkidVehicle()).V
        assert rotation_centre(V)[0] == pytest.approx(0, abs=1e-7)


def test_turn_on_the_spot_has_a_closed_form() -> None:
    turn, heat = turn_on_the_spot(4.0, SkidVehicle())
    found = least_by_newton(sides(-4.0, 4.0), SkidVehicle())
    assert list(found.V) == pytest.approx([0, 0, turn], abs=1e-7)
    assert abs(found.P - heat) < 1e-7 * heat


@pytest.mark.parametrize("rates", [(2.0, 6.0), (-4.0, 4.0)])
def test_front_axle_holds_from_its_offset_on(rates: tuple[float, float]) -> None:
    edge, w = snap_offset(SkidVehicle()), sides(*rates)
    before, after = (SkidVehicle(ahead=edge + step) for step in (-0.01, 0.01))
    hold = axle_twist(w, "front", after)
    assert slip_velocities(hold, w, after)[:2] == pytest.approx(np.zeros((2, 2)), abs=1e-15)
    assert list(least_by_newton(w, after).V) == pytest.approx(list(hold), abs=1e-6)
    assert np.abs(least_by_newton(w, before).V - hold).max() > 1e-3


def test_grid_finds_the_axle_that_holds() -> None:
    vehicle, w = SkidVehicle(ahead=0.09), sides(2.0, 6.0)
    hold = axle_twist(w, "front", vehicle)
    assert least_by_grid(w, vehicle, precision=1e-6) == pytest.approx(hold, abs=1e-5)


def test_rear_axle_holds_as_far_behind() -> None:
    vehicle = SkidVehicle(ahead=-snap_offset(SkidVehicle()) - 0.01)
    w = sides(1.0, 5.0)
    hold = axle_twist(w, "rear", vehicle)
    assert list(least_by_newton(w, vehicle).V) == pytest.approx(list(hold), abs=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_energy_goes_into_torques_and_heat(seed: int) -> None:
    random = np.random.default_rng(seed)
    x, u = random.uniform(-2, 2, 10), random.uniform(-9, 9, 4)
    assert abs(energy_balance(x, u, ODD)) < 1e-8  # [W] of some hundred


def test_energy_along_a_run_is_work_less_heat() -> None:
    u, eps = np.array([6.0, 12.0, 6.0, 12.0]), 1e-2

    def rate(_: float, x: Array) -> Array:
        power = u @ x[6:10] - friction_heat(x[3:6], x[6:10], ODD, eps)
        return np.append(derivative(x[:10], u, ODD, eps), power)

    run = solve_ivp(rate, (0, 0.2), np.zeros(11), "Radau", rtol=1e-7, atol=1e-9)
    end = run.y[:, -1]
    T = kinetic_energy(end[:10], ODD)
    assert T > 1  # [J]
    assert end[10] == pytest.approx(T, rel=1e-5)


def test_free_vehicle_keeps_its_momentum_about_the_centre_of_mass() -> None:
    """Without grip the centre of mass goes straight on, and the yaw rate stays."""
    ice = SkidVehicle(ahead=0.07, left=-0.05, mu=(0.0,) * 4)
    start = np.array([0, 0, 0.3, 1.0, -0.5, 2.0, 1, 2, 3, 4])

    def centre(x: Array) -> complex:
        return complex(x[0] + 1j * x[1] + (ice.ahead + 1j * ice.left) * np.exp(1j * x[2]))

    run = solve_ivp(
        lambda _, x: derivative(x, np.zeros(4), ice),
        (0, 2), start, "DOP853", rtol=1e-10, atol=1e-12, dense_output=True,
    )  # fmt: skip
    places = [centre(run.sol(t)) for t in (0.0, 1.0, 2.0)]
    assert places[2] - places[1] == pytest.approx(places[1] - places[0], abs=1e-7)
    assert run.y[5:, -1] == pytest.approx(start[5:], abs=1e-9)


def test_light_vehicle_moves_as_it_dissipates_least() -> None:
    """Held rates: V settles within O(inertia) + O(eps) of the minimiser."""
    vehicle, w = SkidVehicle(ahead=0.03), sides(2.0, 6.0)
    least = least_by_newton(w, vehicle).V
    errors = []
    for inertia in (1e-1, 1e-2):
        run = solve_ivp(
            lambda _, V, share=inertia: body_acceleration(V, w, vehicle, 1e-4, share),
            (0, 0.6), np.zeros(3), "Radau", rtol=1e-6, atol=1e-8,
        )  # fmt: skip
        errors.append(float(np.abs(run.y[:, -1] - least).max()))
    assert errors[1] < 1e-3
    assert errors[1] < errors[0] / 5
