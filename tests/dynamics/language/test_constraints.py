"""Machines with constraints against the multiplier form, and what the chart promises."""

from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab.systems
from kinolab.dynamics import (
    Body,
    System,
    angle,
    closed,
    force_of,
    length,
    move,
    rate,
    require,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.errors import InputError, SingularError
from tests.dynamics.machines import CONSTRAINED, compiled, road_train, snakeboard
from tests.dynamics.reference import Reference

Array = NDArray[np.float64]
NAMES = sorted(CONSTRAINED)
ROUNDING = 1e-10  # relative; the multiplier form's matrix has a condition of about 1e4


def states(name: str, count: int) -> list[tuple[Array, Array]]:
    """Random states and inputs, inside the chart."""
    model, rng = compiled(name), np.random.default_rng(7)
    made = [(rng.uniform(-1, 1, model.nx), rng.uniform(-2, 2, model.nu)) for _ in range(count)]
    if name == "snakeboard":  # its chart ends where both wheel sets point the same way
        for x, _ in made:
            x[4:6] = 0.6 + 0.2 * x[4], -0.5 + 0.2 * x[5]
    return made


@pytest.mark.parametrize("name", NAMES)
def test_the_reduced_form_is_the_multiplier_form(name: str) -> None:
    model = compiled(name)
    reference = Reference(model.system)
    for x, u in states(name, 6):
        q = x[: model.nq]
        q_dot = reference.full_rates(q, x[model.nq :], model.independent)
        q_ddot, _ = reference.multiplier_form(q, q_dot, u)
        expected = np.concatenate([q_dot, q_ddot[list(model.independent)]])
        atol = ROUNDING * (1 + np.abs(expected).max())
        np.testing.assert_allclose(model.f(x, u), expected, rtol=0, atol=atol)
        np.testing.assert_allclose(model.velocity(x, u), q_dot, rtol=0, atol=atol)
        np.testing.assert_allclose(model.mass_matrix(q), reference.mass_matrix(q), atol=atol)
        assert model.energy(x) == pytest.approx(reference.energy(q, q_dot), rel=1e-10)


@pytest.mark.parametrize("name", NAMES)
def test_constraints_hold_along_a_run(name: str) -> None:
    """By construction: nothing is integrated that could leave them; 1e-9 m/s is rounding."""
    model = compiled(name)
    x0, u = states(name, 1)[0]
    x0[model.nq :] *= 0.3
    run = solve_ivp(lambda _, x: model.f(x, u * 0.01), (0, 1), x0, "DOP853", rtol=1e-8)
    assert run.success
    residual = model.constraint_residual(np.ascontiguousarray(run.y.T))
    assert np.abs(residual).max() < 1e-9
    w = np.real(Reference(model.system).covectors(run.y[: model.nq].T))
    q_dot = model.velocity(np.ascontiguousarray(run.y.T))
    assert np.abs(np.einsum("tci,ti->tc", w, q_dot)).max() < 1e-9
    assert np.abs(q_dot).max() > 0.01  # the machine moves at all


@pytest.mark.parametrize("name", NAMES)
def test_constraint_forces_do_no_work_along_a_run(name: str) -> None:
    """G2 with constant inputs, their power from the poses."""
    model = compiled(name)
    reference = Reference(model.system)
    x0, u = states(name, 1)[0]
    x0[model.nq :] *= 0.3
    u = (0.001 if name == "snakeboard" else 0.1) * u  # its wheels turn by 77 rad/s^2 otherwise

    def rates(_: float, both: Array) -> Array:
        x = both[:-1]
        powers = reference.unit_powers(x[: model.nq], model.velocity(x))
        return np.append(model.f(x, u), u @ powers)

    run = solve_ivp(rates, (0, 0.5), np.append(x0, 0.0), "DOP853", rtol=1e-8, atol=1e-9)
    change = sum(model.energy(run.y[:-1, -1])) - sum(model.energy(x0))
    assert change == pytest.approx(run.y[-1, -1], abs=1e-6)  # [J] of about 1 J


@pytest.mark.parametrize("name", NAMES)
def test_velocity_terms_stay_quadratic_under_constraints(name: str) -> None:
    model = compiled(name)
    n = model.nq
    for x, u in states(name, 4):
        at = [model.f(np.concatenate([x[:n], s * x[n:]]), u)[n:] for s in (0, 1, 2)]
        scale = 1 + np.abs(at[2]).max()
        np.testing.assert_allclose(at[2] - at[0], 4 * (at[1] - at[0]), atol=1e-9 * scale)


@pytest.mark.parametrize("name", ["cart", "road_train", "rolling_disk"])
def test_moving_and_yawing_a_vehicle_moves_and_yaws_its_motion(name: str) -> None:
    """G5: none of these machines knows where it is or what its heading is."""
    model = kinolab.systems.get(name).model() if name == "rolling_disk" else compiled(name)
    index = model.coordinate_names.index
    heading = next(n for n in ("psi", "th_0") if n in model.coordinate_names)
    rng = np.random.default_rng(3)
    for _ in range(4):
        x, u, turn = rng.uniform(-0.7, 0.7, model.nx), rng.uniform(-1, 1, model.nu), 0.8
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, -s], [s, c]])
        place = [index("x"), index("y")]
        moved = x.copy()
        moved[place] = R @ x[place] + [3.0, -2.0]
        moved[index(heading)] += turn
        f = model.f(x, u)
        f[place] = R @ f[place]
        np.testing.assert_allclose(model.f(moved, u), f, atol=1e-10 * (1 + np.abs(f).max()))


def test_the_cart_obeys_the_closed_form_of_a_differential_drive() -> None:
    """Forward (m + 2 I/r^2) a = (R + L)/r, turning (I_z + I b^2 / (2 r^2)) alpha = b (R - L)/(2 r).

    Wheels carry mass here: m and I_z count them. Reacting torques do not change these.
    """
    model = compiled("cart")
    r, b, m, wheel = 0.0975, 0.33, 8.0 + 2 * 0.5, 0.02
    I_z = 0.4 + 2 * (0.5 * (b / 2) ** 2 + wheel / 2)
    rng = np.random.default_rng(0)
    for _ in range(5):
        x, (L, R) = rng.uniform(-1, 1, 7), rng.uniform(-1, 1, 2)
        x[5:] = 0.0
        left, right = model.f(x, [L, R])[5:]
        forward, turning = r * (right + left) / 2, r * (right - left) / b
        assert forward == pytest.approx((R + L) / r / (m + 2 * wheel / r**2), rel=1e-10)
        inertia = I_z + wheel * b**2 / (2 * r**2)
        assert turning == pytest.approx(b * (R - L) / (2 * r) / inertia, rel=1e-10)


def test_the_snakeboard_obeys_its_published_reduction() -> None:
    """phi_b = -phi_f = phi: v_x and theta_dot from the momentum p; J + Jr + 2 Jw = m l^2.

    Source: Bloch, Krishnaprasad, Marsden, Murray, Arch. Rational Mech. Anal. 136, 1996.
    """
    model = compiled("snakeboard")
    m, half, Jr = 6.0, 0.2, 0.072
    names = list(model.state_names)
    rng = np.random.default_rng(1)
    for _ in range(5):
        phi, phi_d, psi_d, th_d = rng.uniform(0.2, 1.0, 4)
        x = np.zeros(model.nx)
        x[names.index("phi_b")], x[names.index("phi_f")] = phi, -phi
        x[names.index("phi_b_dot")], x[names.index("phi_f_dot")] = phi_d, -phi_d
        x[names.index("psi_dot")], x[names.index("th_dot")] = psi_d, th_d
        v_x, v_y = model.velocity(x)[:2]  # th = 0: world axes are the board's
        # th_d = tan(phi) p / (2 m l^2) - (Jr / (m l^2)) sin^2(phi) psi_d, solved for p
        share = Jr / (m * half**2)
        p = (th_d + share * np.sin(phi) ** 2 * psi_d) * 2 * m * half**2 / np.tan(phi)
        expected = -p / (2 * m * half) + Jr / (m * half) * np.sin(phi) * np.cos(phi) * psi_d
        assert v_x == pytest.approx(expected, rel=1e-10)
        assert v_y == pytest.approx(0.0, abs=1e-12)


def test_more_than_three_constraints_are_solved_at_zero_angles_too() -> None:
    """The rotations meet pairs of entries that both vanish in a straight train."""
    model = compiled("road_train")
    x = np.zeros(model.nx)
    x[model.state_names.index("phi_dot")] = 2.0
    f = model.f(x)
    assert np.isfinite(f).all()
    assert f[0] == pytest.approx(0.3 * 2.0)  # R phi_dot, straight on
    np.testing.assert_allclose(f[3:], 0.0, atol=1e-14)


def test_a_constraint_with_changing_coefficients_has_its_drift() -> None:
    """y_dot = x x_dot: y_ddot = x_dot^2 + x x_ddot, and (1 + x^2) x_ddot = -x x_dot^2."""
    x, y = length("x"), length("y")
    bead = Body("bead", move(x, y), mass=2.0)
    wire = zero(rate(y) - x * rate(x), "wire")
    model = System("s", bodies=[bead], constraints=[wire], velocities=[x]).model()
    assert model.state_names == ("x", "y", "x_dot")
    f = model.f([0.7, 0.0, 1.3])
    assert f[1] == pytest.approx(0.7 * 1.3, rel=1e-14)
    assert f[2] == pytest.approx(-0.7 * 1.3**2 / (1 + 0.7**2), rel=1e-13)


# The chart


def test_outside_the_chart_the_equations_are_refused() -> None:
    model = compiled("knife_edge")  # velocities x and th: y_dot = tan(th) x_dot
    model.f([0, 0, 1.5, 1, 0], [0, 0])
    with pytest.raises(SingularError) as caught:
        model.f([0, 0, np.pi / 2, 1, 0], [0, 0])
    assert "outside the chart of the independent velocities: condition number" in str(caught.value)
    assert "th=1.5708" in str(caught.value)


def test_a_chart_of_one_constraint_is_left_before_its_digits_are() -> None:
    """cos(th) = 1e-10 turns a rate of 1 m/s into 1e10 m/s and a rounding into a force."""
    model = compiled("knife_edge")
    with pytest.raises(SingularError):
        model.f([0, 0, np.pi / 2 - 1e-10, 1, 0], [0, 0])


def test_a_step_across_the_edge_of_the_chart_is_refused() -> None:
    model = compiled("knife_edge")
    with pytest.raises(SingularError):
        model.step([0, 0, np.pi / 2, 1, 0], [0, 0], 0.1)


def test_a_chart_of_two_constraints_is_left_where_their_rows_meet() -> None:
    """Snakeboard wheels across the board: both rows hold the same direction."""
    model = snakeboard().model()
    x = np.zeros(model.nx)
    x[model.nq :] = 0.1
    x[[model.state_names.index("phi_b"), model.state_names.index("phi_f")]] = 0.0
    with pytest.raises(SingularError):
        model.f(x)  # x and y from two parallel rows
    x[model.state_names.index("phi_b")] = 0.3
    assert np.isfinite(model.f(x)).all()


@pytest.mark.parametrize("away", [0.0, 1e-10])
def test_a_chart_of_five_constraints_is_left_where_it_is_singular(away: float) -> None:
    """With x_dot given and the tractor square to it, nothing tells how fast the wheel rolls."""
    made = road_train()
    x, th = (c for c in made.coordinates if c.name in ("x", "th_0"))
    system = System(
        "train",
        bodies=made.bodies,
        constraints=made.constraints,
        inputs=made.inputs,
        velocities=[x, th],
    )
    model = system.model()
    state = np.full(model.nx, 0.1)
    assert np.isfinite(model.f(state)).all()
    state[model.state_names.index("th_0")] = np.pi / 2 - away
    w = np.real(Reference(system).covectors(state[: model.nq]))
    dependent = [i for i in range(model.nq) if i not in model.independent]
    assert np.linalg.cond(w[:, dependent]) > 1e9
    with pytest.raises(SingularError):
        model.f(state)


def test_the_dependent_coordinate_is_the_one_that_the_constraint_determines() -> None:
    """1e-6 x_dot + y_dot = 0 determines y_dot; taking x_dot from it would divide by 1e-6."""
    x, y = length("x"), length("y")
    body = Body("b", move(x, y), mass=1)
    line = zero(sp.Float(1e-6) * rate(x) + rate(y), "line")
    model = System("s", bodies=[body], constraints=[line]).model()
    assert model.state_names == ("x", "y", "x_dot")


def test_a_good_chart_is_preferred_to_one_that_is_singular_at_some_state() -> None:
    """V.y = -sin(th) x_dot + cos(th) y_dot + 2 th_dot: only th_dot is determined everywhere."""
    x, y, th = length("x"), length("y"), angle("th")
    blade = move(x, y) @ rot_z(th)
    body = Body("b", blade, mass=1, inertia=0.1)
    tip = velocity(blade @ move(2))
    model = System("s", bodies=[body], constraints=[zero(tip.y, "tip")]).model()
    assert model.state_names == ("x", "y", "th", "x_dot", "y_dot")
    assert np.isfinite(model.f([0, 0, 0, 1, 1])).all()


def test_named_velocities_are_taken() -> None:
    x, y, th = length("x"), length("y"), angle("th")
    blade = move(x, y) @ rot_z(th)
    parts: dict[str, Any] = {
        "bodies": [Body("b", blade, mass=1, inertia=0.1)],
        "constraints": [zero(velocity(blade).y, "edge")],
    }
    for chosen, names in (([y, th], ("y_dot", "th_dot")), ([th, x], ("x_dot", "th_dot"))):
        model = System("s", **parts, velocities=chosen).model()
        assert model.state_names[3:] == names


def test_constraints_may_come_in_any_order_and_scale() -> None:
    made = CONSTRAINED["cart"]()
    scaled = System(
        "cart",
        bodies=made.bodies,
        constraints=[zero(-3 * c.velocity, c.name) for c in reversed(made.constraints)],
        inputs=made.inputs,
        velocities=[made.coordinates[i] for i in compiled("cart").independent],
    ).model()
    for x, u in states("cart", 3):
        f = compiled("cart").f(x, u)
        np.testing.assert_allclose(scaled.f(x, u), f, atol=1e-10 * (1 + np.abs(f).max()))


def test_a_machine_that_constraints_hold_entirely_is_no_crash() -> None:
    """Two constraints on two coordinates leave no motion: an error that says so, or x = q."""
    x, y = length("x"), length("y")
    system = System(
        "held",
        bodies=[Body("b", move(x, y), mass=1)],
        constraints=[zero(rate(x), "x stays"), zero(rate(y), "y stays")],
    )
    try:
        model = system.model()
    except InputError as error:
        assert "held" in str(error)  # noqa: PT017
    else:
        np.testing.assert_array_equal(model.f([1.0, 2.0]), [0.0, 0.0])


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("velocities", [None, "all"])
def test_the_force_of_a_rope_has_the_sign_that_its_slack_or_stretch_gives_it(
    sign: int, velocities: Any
) -> None:
    """A mass that hangs at rest pulls with m g; swinging through with v, with m (g + v^2/l)."""
    x, y = length("x"), length("y")
    m, l, g, v = 1.5, 2.0, 9.81, 3.0  # noqa: E741
    weight = Body("weight", move(x, y), mass=m)
    slack = l - sp.sqrt(x**2 + y**2)
    rope = closed(sign * slack, "rope")
    system = System(
        "hanging",
        bodies=[weight],
        gravity=toward("-y", g),
        constraints=[rope],
        velocities=velocities or [x],
        requirements=[require(sign * force_of(rope), "the rope only pulls")],
    )
    model = system.model()
    still = np.zeros(model.nx)
    still[1] = -l
    moving = still.copy()
    moving[2] = v
    (tension,), (swinging,) = (model.requirements(state, []) for state in (still, moving))
    assert tension == pytest.approx(m * g, rel=1e-12)
    assert swinging == pytest.approx(m * (g + v**2 / l), rel=1e-12)


def test_the_force_of_a_velocity_that_is_held_acts_towards_larger_ones() -> None:
    """Gravity pulls down with m g; what holds the velocity upwards at zero pushes up with m g."""
    x, y = length("x"), length("y")
    held = zero(rate(y), "table")
    system = System(
        "on a table",
        bodies=[Body("block", move(x, y), mass=2.0)],
        gravity=toward("-y", 9.81),
        constraints=[held],
        requirements=[require(force_of(held), "the table only pushes")],
    )
    model = system.model()
    assert model.requirements(model.rest(), []) == pytest.approx([2.0 * 9.81], rel=1e-12)
