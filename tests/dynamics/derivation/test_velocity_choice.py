"""Independent velocities that determine the motion at every configuration."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from kinolab import systems
from kinolab.analyze.describe.description import describe
from kinolab.analyze.describe.description_text import described_as_text
from kinolab.analyze.examine import examine
from kinolab.dynamics import (
    Body,
    Model,
    QuasiVelocity,
    System,
    angle,
    length,
    move,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.derivation.singularity import singularity_of
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.model.units import state_units
from kinolab.errors import InputError, SingularError
from kinolab.numerics.arrays import Array
from tests.dynamics.wheeled import chaplygin_sleigh, roller_racer, tractor_with_trailers

MACHINES = [chaplygin_sleigh, roller_racer, tractor_with_trailers]
HEADINGS = [0.0, np.pi / 2, -np.pi / 2, np.pi, 0.7]
Make = Callable[..., System]


def moving(model: Model, heading: float, seed: int) -> tuple[Array, Array]:
    """A random state at a heading, and inputs."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.1, 1.1, model.nx)
    x[2] = heading
    return x, rng.uniform(*model.control_bounds.T)


@pytest.mark.parametrize("heading", HEADINGS)
def test_a_sleigh_moves_as_its_closed_form_says_at_every_heading(heading: float) -> None:
    """v_dot = a omega^2 and omega_dot = -m a v omega/(J + m a^2), free of inputs."""
    system = chaplygin_sleigh()
    model, p = system.model(), system.parameter_values
    assert model.state_names == ("x", "y", "theta", "V_x", "theta_dot")
    assert state_units(model) == ("m", "m", "rad", "m/s", "rad/s")
    v, omega = 0.7, 0.4
    found = model.f([0.3, -0.2, heading, v, omega], [0.0, 0.0])
    inertia = p["J"] + p["m"] * p["a"] ** 2
    expected = [v * np.cos(heading), v * np.sin(heading), omega, p["a"] * omega**2]
    expected.append(-p["m"] * p["a"] * v * omega / inertia)
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("make", MACHINES)
def test_quasi_velocities_move_a_machine_as_multipliers_do(make: Make, heading: float) -> None:
    """With all rates as states, nothing is chosen: q_ddot must be the same, S v_dot + S_dot v."""
    model, whole = make().model(), make(velocities="all").model()
    x, u = moving(model, heading, 3)
    f = model.f(x, u)
    reference = whole.f(np.concatenate([x[: model.nq], model.velocity(x, u)]), u)
    h = 1e-6  # of a central difference of velocities along the motion, whose error is h^2
    q_ddot = (model.velocity(x + h * f, u) - model.velocity(x - h * f, u)) / (2 * h)
    np.testing.assert_allclose(f[: model.nq], reference[: model.nq], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(q_ddot, reference[model.nq :], rtol=1e-7, atol=1e-7)
    forces = model.constraint_forces(x, u)
    held = whole.constraint_forces(np.concatenate([x[: model.nq], model.velocity(x, u)]), u)
    np.testing.assert_allclose(forces, held, rtol=1e-6, atol=1e-6)


def test_an_undriven_roller_racer_keeps_its_energy_through_heading_90_degrees() -> None:
    model = roller_racer().model()
    start = np.array([0.0, 0.0, 1.2, 0.3, 0.4, 0.5])  # turns from 69 degrees on

    def rate(_: float, x: Array) -> Array:
        return model.f(x, [0.0])

    run = solve_ivp(rate, (0.0, 2.0), start, method="DOP853", rtol=1e-11, atol=1e-12)
    kinetic = model.energy(np.ascontiguousarray(run.y.T))[0]
    assert run.y[2, 0] < np.pi / 2 < run.y[2].max()
    np.testing.assert_allclose(kinetic, kinetic[0], rtol=1e-9)


@pytest.mark.parametrize("make", MACHINES)
def test_derivatives_by_quasi_velocities_are_exact(make: Make) -> None:
    model = make().model()
    x, u = moving(model, np.pi / 2, 5)
    h = 1e-6
    columns = [(model.f(x + h * e, u) - model.f(x - h * e, u)) / (2 * h) for e in np.eye(len(x))]
    np.testing.assert_allclose(model.jacobian(x, u)[0], np.array(columns).T, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("make", MACHINES)
def test_a_right_machine_is_examined_as_right(make: Make) -> None:
    assert examine(make()).broken == ()
    assert singularity_of(make()) is None


def test_printed_equations_of_a_sleigh_are_the_textbooks() -> None:
    text = chaplygin_sleigh().model().equations().text()
    reduced = text.partition("reduced to the independent velocities\n")[2].splitlines()
    assert reduced == [
        "  -m a θ̇² + m V̇_x = push",
        "  (J + m a²) θ̈ + m a V_x θ̇ = turn",
    ]
    assert " = cos(θ) V_x\n" in text
    assert " = sin(θ) V_x\n" in text


@pytest.mark.parametrize("make", [chaplygin_sleigh, roller_racer])
def test_printed_equations_do_what_the_model_does(make: Make) -> None:
    system = make()
    model = system.model()
    x, u = moving(model, 2.0, 11)
    values = dict(zip(model.state_names, x, strict=True)) | system.parameter_values
    values |= dict(zip(model.control_names, u, strict=True))
    changes = model.f(x, u)[model.nq :]
    values |= {"Vdot_x": changes[0], "theta_ddot": changes[1]}
    equations = model.equations()
    assert len(equations.reduced) == 2
    for equation in equations.reduced:
        known = {symbol: values[symbol.name] for symbol in equation.free_symbols}
        left, right = (float(side.subs(known)) for side in equation.args)
        assert left == pytest.approx(right, abs=1e-9)


@pytest.mark.parametrize("make", [roller_racer, tractor_with_trailers])
def test_velocities_are_the_speed_and_turn_rate_of_the_first_body(make: Make) -> None:
    """As textbooks take them, which leaves one determinant for all configurations."""
    model = make().model()
    assert model.velocity_names == ("V_x", "theta_dot")
    assert "along its x axis" in model.quasi_velocities[0].direction


@pytest.mark.parametrize("name", ["rolling_disk", "car", "snakeboard", "unicycle2_v0"])
def test_regular_coordinate_rates_remain_the_velocities(name: str) -> None:
    model = systems.get(name).model()
    assert not model.quasi_velocities
    assert set(model.velocity_names) <= set(model.rate_names)


@pytest.mark.parametrize(("begin", "swing", "turns"), [(0.7, 1.58, 2), (1.0, 2.18, 4)])
def test_where_every_choice_is_singular_somewhere_the_farthest_from_it_is_made(
    begin: float, swing: float, turns: int
) -> None:
    """A blade at the angle a = begin + swing sin(turns theta) in its body.

    The velocity along the body's x axis determines the motion where cos a is not zero, the one
    along y where sin a is not; each is zero at some heading. Which one is better says the mean of
    its logarithm over a turn.
    """
    x, y, theta = length("x"), length("y"), angle("theta")
    frame = move(x, y) @ rot_z(theta)
    v, a = velocity(frame), begin + swing * sympy.sin(turns * theta)
    across = zero(v.y * sympy.cos(a) - v.x * sympy.sin(a), "no sideslip")
    blade = Body("blade", frame, mass=1.0, inertia=(0.1, 0.1, 0.1))
    model = System("blade", bodies=[blade], constraints=[across]).model()
    at = begin + swing * np.sin(turns * np.linspace(0.0, 2 * np.pi, 100_000, endpoint=False))
    means = {"V_x": np.log(np.abs(np.cos(at))).mean(), "V_y": np.log(np.abs(np.sin(at))).mean()}
    assert model.velocity_names == (max(means, key=lambda name: means[name]), "theta_dot")


def test_a_sleigh_is_as_fast_as_its_coordinates_may_be() -> None:
    """Limits of 2 m/s along x and y leave sqrt(8) m/s along a diagonal."""
    model = chaplygin_sleigh().model()
    assert model.state_bounds[3, 1] == pytest.approx(np.sqrt(8), rel=0.005)
    assert model.state_bounds[3, 1] <= 2.83


def test_velocities_may_be_named_by_the_author() -> None:
    x, y, theta = length("x"), length("y"), angle("theta")
    blade = move(x, y) @ rot_z(theta)
    speed = QuasiVelocity("v", velocity(blade).x, speed=1.5)
    skate = chaplygin_sleigh().changed(
        bodies=[Body("skate", blade, mass=1.0, inertia=(0.1, 0.1, 0.1))],
        constraints=[zero(velocity(blade).y, "no sideslip")],
        inputs=[],
        coordinates=[x, y, theta],
        velocities=[theta, speed],
    )
    model = skate.model()
    assert model.state_names == ("x", "y", "theta", "v", "theta_dot")
    assert model.state_bounds[3].tolist() == [-1.5, 1.5]
    read = machine_from_json(machine_to_json(skate))
    assert machine_to_json(read) == machine_to_json(skate)
    np.testing.assert_array_equal(System.of(read).model().f(np.ones(5)), model.f(np.ones(5)))


def test_a_named_quasi_velocity_of_another_machine_is_refused() -> None:
    other = QuasiVelocity("v", velocity(move(length("z"))).x)
    with pytest.raises(InputError, match="velocity 'v': z_dot is no coordinate, rate or parameter"):
        chaplygin_sleigh(velocities=[other])


def test_velocities_that_are_singular_somewhere_say_where_and_what_helps() -> None:
    system = chaplygin_sleigh("x", "theta")
    found = singularity_of(system)
    assert found is not None
    assert abs(np.cos(found.at["theta"])) < 1e-9
    assert set(found.at) == {"theta"}
    cure = "Leave out velocities=[…], so that kinolab chooses them."
    assert found.sentence.startswith("x_dot and theta_dot do not determine the motion at theta = ")
    assert found.sentence.endswith(cure)
    assert found.sentence in " ".join(described_as_text(describe(system)).split())
    checks = examine(system).laws
    assert any(found.sentence in check.note for check in checks)
    assert all(check.holds for check in checks)
    with pytest.raises(SingularError) as caught:
        system.model().f([0, 0, np.pi / 2, 1, 0], [0, 0])
    assert cure in str(caught.value)
