"""Which constraints are holonomic in disguise, of machines whose integrals are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Coordinate,
    InvolutiveClosure,
    System,
    allowed_motions,
    angle,
    closed,
    involutive_closure,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)
from tests.machines import (
    four_bar,
    four_bar_by_multipliers,
    rope_pendulum,
    trident_snake,
)


def is_found(closure: InvolutiveClosure, expected: str) -> bool:
    """Whether the one integral is the expected one or its negative."""
    (found,) = closure.integrals
    named = {symbol.name: symbol for symbol in found.free_symbols}
    other = sp.sympify(expected, locals=named)
    return any(sp.simplify(found - sign * other) == 0 for sign in (1, -1))


def wheel_on_a_rail() -> System:
    """A wheel that rolls along a line: x_dot = R phi_dot is x = R phi in disguise."""
    x, phi, R = length("x"), angle("phi"), parameter("R", 0.4, "m")
    wheel = Body("wheel", move(x) @ rot_y(phi), mass=1.0, inertia=(0.1, 0.2, 0.1))
    return System("wheel", bodies=[wheel], constraints=[zero(rate(x) - R * rate(phi), "rolling")])


def test_rolling_along_a_line_is_holonomic_in_disguise() -> None:
    found = involutive_closure(wheel_on_a_rail())
    assert found.integrable == ("rolling",)
    assert is_found(found, "x - R * phi")
    assert (found.growth, found.leaf, found.dimension) == ((1,), 1, 2)
    assert (found.disguised, found.nonholonomic) == (1, 0)


def test_rolling_in_the_plane_is_not() -> None:
    found = involutive_closure(systems.get("rolling_disk"))
    assert (found.integrable, found.integrals) == ((), ())
    assert (found.leaf, found.disguised, found.nonholonomic) == (4, 0, 2)


def test_the_wheels_of_a_differential_drive_tell_its_heading() -> None:
    """psi = r / b (phi_r - phi_l) + constant; neither wheel's rolling alone can be integrated."""
    found = involutive_closure(systems.get("diff_drive", r=0.1, b=0.4))
    assert found.integrable == ()
    assert found.combinations == ("'left wheel rolls' - 'right wheel rolls'",)
    assert is_found(found, "b * psi - r * (phi_r - phi_l)")
    assert (found.disguised, found.nonholonomic) == (1, 2)


def test_the_integral_of_a_differential_drive_is_constant_along_its_motion() -> None:
    """As the compiled model moves."""
    model = systems.get("diff_drive").model()
    start = np.array([0, 0, 0.3, 0.1, -0.4, 2.0, 5.0])

    def integral(x: np.ndarray) -> float:
        return float(x[2] + 0.0975 / 0.33 * (x[3] - x[4]))

    end = model.step(start, [0.1, -0.3], 1.0, substeps=20)
    assert abs(end[2] - start[2]) > 0.1  # [rad]; it turns
    assert integral(end) == pytest.approx(integral(start), abs=1e-12)


def test_an_integrable_constraint_beside_others_is_named() -> None:
    """A blade that also measures how far it has turned."""
    x, y, th, s = length("x"), length("y"), angle("th"), angle("s")
    blade = move(x, y) @ rot_z(th)
    body = Body("blade", blade @ rot_z(s), mass=1.0, inertia=(1, 1, 1))
    gear = zero(rate(s) - 3 * rate(th), "gear")
    edge = zero(velocity(blade).y, "edge")
    found = involutive_closure(System("blade", bodies=[body], constraints=[edge, gear]))
    assert found.integrable == ("gear",)
    assert found.combinations == ()
    assert is_found(found, "s - 3 * th")
    assert found.nonholonomic == 1


def bead(held: Callable[[Coordinate, Coordinate], sp.Expr]) -> System:
    """A bead in the plane with a constraint on its velocity."""
    x, y = length("x", 0.2, 2.0), length("y", 0.2, 2.0)
    body = Body("bead", move(x, y), mass=1.0)
    return System("bead", bodies=[body], constraints=[zero(held(x, y), "wire")])


@pytest.mark.parametrize(
    ("held", "integral"),
    [
        (lambda x, y: rate(y) - sp.cos(x) * rate(x), "y - sin(x)"),
        (lambda x, y: x * rate(x) + y * rate(y), "(x**2 + y**2) / 2"),
        (lambda x, y: y * rate(x) + x * rate(y), "x * y"),
        # times a factor: the function is linear, and found without the factor
        (lambda x, y: sp.exp(x * y) * (rate(x) - 2 * rate(y)), "x - 2 * y"),
    ],
)
def test_what_a_wire_holds_is_found(
    held: Callable[[Coordinate, Coordinate], sp.Expr], integral: str
) -> None:
    found = involutive_closure(bead(held))
    assert found.integrable == ("wire",)
    assert is_found(found, integral)


def test_a_wire_without_a_formula_is_still_holonomic() -> None:
    """y_dot = exp(-x^2 y^2) x_dot: in two dimensions every line field has leaves."""
    found = involutive_closure(bead(lambda x, y: rate(y) - sp.exp(-((x * y) ** 2)) * rate(x)))
    assert (found.integrable, found.integrals) == (("wire",), ())


@pytest.mark.parametrize("name", ["diff_drive", "wheel"])
def test_integrals_do_not_change_along_allowed_motions(name: str) -> None:
    """Their gradient annihilates every field, by SymPy."""
    system = wheel_on_a_rail() if name == "wheel" else systems.get(name)
    (integral,) = involutive_closure(system).integrals
    assert all(sp.simplify(field.along(integral)) == 0 for field in allowed_motions(system))


@pytest.mark.parametrize("make", [four_bar, four_bar_by_multipliers, rope_pendulum])
def test_what_is_stated_as_holonomic_is_not_in_disguise(make: object) -> None:
    found = involutive_closure(make())  # type: ignore[operator]
    assert (found.leaf, found.disguised, found.nonholonomic) == (1, 0, 0)
    assert found.integrable == ()


def test_a_constraint_that_repeats_another_is_told() -> None:
    assert involutive_closure(four_bar_by_multipliers()).redundant == ("loop x again",)


def test_a_loop_held_by_its_velocity_is_holonomic_in_disguise() -> None:
    """A bead on a circle, once by its position and once by its velocity."""
    x, y = length("x", 0.2, 2), length("y", 0.2, 2)
    bead = Body("bead", move(x, y), mass=1.0)
    by_position = System("bead", bodies=[bead], constraints=[closed(x**2 + y**2 - 1, "ring")])
    moving = zero(x * rate(x) + y * rate(y), "ring")
    by_velocity = System("bead", bodies=[bead], constraints=[moving])
    assert involutive_closure(by_position).integrable == ()
    assert involutive_closure(by_velocity).integrable == ("ring",)


def test_three_wheels_of_a_trident_snake_forbid_no_configuration() -> None:
    found = involutive_closure(trident_snake())
    assert (found.growth, found.nonholonomic, found.disguised) == ((3, 6), 3, 0)
