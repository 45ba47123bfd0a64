"""Growth vectors that are known, of fields as expressions and of machines.

Sources:
    Brockett, Control theory and singular Riemannian geometry, New Directions in Applied
        Mathematics, 1981: the nonholonomic integrator.
    Murray, Sastry, Nonholonomic motion planning: steering using sinusoids, IEEE Trans. Automatic
        Control 38(5), 1993: car and coin.
    Jean, The car with N trailers, ESAIM: COCV 1, 1996: N + 2 fields where nothing is at right
        angles, F_(N+3), a Fibonacci number, at worst.
    Ishikawa, Trident snake robot: locomotion analysis and control, IFAC NOLCOS, 2004: (3, 6).
    Bullo, Lewis, IEEE Trans. Robotics and Automation 19(3), 2003: the snakeboard.
    Crouch, Spacecraft attitude control and stabilization, IEEE Trans. Automatic Control 29(4),
        1984: two wheels turn a satellite anywhere where its angular momentum is zero.
    Cartan, Ann. Sci. Ecole Normale Superieure 27, 1910: (2, 3, 5), two surfaces that roll.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp

from kinolab import systems
from kinolab.dynamics import (
    Attitude,
    Body,
    Coordinate,
    Rate,
    System,
    VectorField,
    VectorFields,
    allowed_motions,
    angle,
    filtration,
    growth_vector,
    length,
    move,
    orient,
    rate,
    rot_z,
    rotation,
    turn_rate,
    vector_fields,
    velocity,
    zero,
)
from kinolab.dynamics.lagrange.energies import kinetic_energy
from kinolab.errors import InputError, UnknownNameError
from tests import registered
from tests.machines import MACHINES as TEST_MACHINES
from tests.machines import kinematic_car, rope_pendulum, trident_snake, wheeled_hull
from tests.oracles.prime_field import growth_over_primes

x, y, z, w, s = sp.symbols("x y z w s", real=True)


def of(*components: tuple[Any, ...]) -> list[VectorField]:
    symbols = (x, y, z, w, s)[: len(components[0])]
    return [VectorField(symbols, entry) for entry in components]


FIELDS: dict[str, tuple[list[VectorField], tuple[int, ...]]] = {
    "Brockett's integrator": (of((1, 0, -y), (0, 1, x)), (2, 3)),
    "chained form": (of((1, 0, y, z, w), (0, 1, 0, 0, 0)), (2, 3, 4, 5)),
    "Cartan's": (
        of((1, 0, -y / 2, 0, -(x**2 + y**2) / 2), (0, 1, x / 2, (x**2 + y**2) / 2, 0)),
        (2, 3, 5),
    ),
    "planes that slide": (of((1, 0, 0), (0, 1, 0)), (2,)),
}


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("exact", [False, True])
def test_fields_of_the_literature_have_their_growth_vectors(name: str, exact: bool) -> None:
    fields, expected = FIELDS[name]
    assert growth_vector(fields, exact=exact) == expected


def test_a_double_integrator_is_spanned_by_its_bracket() -> None:
    """x_dot = v, v_dot = u: [f, g] = (-1, 0)."""
    fields = VectorFields.of((x, y), {"u": (0, 1)}, drift=(y, 0))
    found = filtration(fields, {}, strong=True)
    assert found.growth == (1, 2)
    assert found.full


def test_martinets_surface_is_singular_where_it_is_flat() -> None:
    """(1, 0, y^2 / 2) and (0, 1, 0): (2, 3) but on y = 0, where it is (2, 2, 3)."""
    fields = of((1, 0, y**2 / 2), (0, 1, 0))
    assert growth_vector(fields, {"y": 0.5}) == (2, 3)
    assert growth_vector(fields, {y: 0}) == growth_vector(fields, {y: 0}, exact=True) == (2, 2, 3)


# --- machines ---


def zero_momentum_satellite() -> System:
    """The satellite with its third wheel stuck, free of momentum: dT / domega = 0.

    The momentum in body axes follows from the kinetic energy that kinolab derives.
    """
    whole = wheeled_hull()
    (R,) = (c for c in whole.coordinates if isinstance(c, Attitude))
    wheels = [c for c in whole.coordinates if isinstance(c, Coordinate)]
    energy = kinetic_energy(whole)
    momenta = [sp.expand(sp.diff(energy, turn)) for turn in turn_rate(R)]
    stuck = zero(rate(wheels[2]), "stuck")
    return System(
        "zero_momentum",
        bodies=[Body(body.name, body.frame) for body in whole.bodies],
        constraints=[
            *(zero(p, f"momentum about {a}") for p, a in zip(momenta, "xyz", strict=True)),
            stuck,
        ],
        inputs=[Rate(f"motor_{q.name}", on=q, limit=1.0) for q in wheels[:2]],
    )


def two_turns() -> System:
    """The same without its wheels' angles: an attitude that is turned about x and y."""
    R = rotation("R")
    wx, wy, wz = turn_rate(R)
    return System(
        "two_turns",
        bodies=[Body("hull", orient(R))],
        constraints=[zero(wz, "none about z")],
        inputs=[Rate("x", on=wx, limit=1.0), Rate("y", on=wy, limit=1.0)],
    )


MACHINES: dict[str, tuple[Callable[[], System], tuple[int, ...]]] = {
    "unicycle": (lambda: systems.get("unicycle1_v0"), (2, 3)),
    "coin": (lambda: systems.get("rolling_disk"), (2, 3, 4)),
    "car": (kinematic_car, (2, 3, 4)),
    "snakeboard": (lambda: systems.get("snakeboard"), (3, 4, 6)),
    "trident snake": (trident_snake, (3, 6)),
    "satellite with two turns": (two_turns, (2, 3)),
    "satellite with two wheels": (zero_momentum_satellite, (2, 3, 5)),
}


@pytest.mark.parametrize("name", MACHINES)
def test_machines_of_the_literature_have_their_growth_vectors(name: str) -> None:
    make, expected = MACHINES[name]
    assert growth_vector(allowed_motions(make())) == expected


@pytest.mark.parametrize("name", ["unicycle", "coin", "car", "satellite with two wheels"])
def test_exact_ranks_are_those_of_singular_values(name: str) -> None:
    make, expected = MACHINES[name]
    assert growth_vector(allowed_motions(make()), exact=True) == expected


@pytest.mark.parametrize("psi", [0, sp.pi / 2, sp.atan(sp.Rational(3, 4))])
def test_a_chosen_rational_point_is_exact(psi: Any) -> None:
    fields = allowed_motions(systems.get("rolling_disk"))
    assert growth_vector(fields, {"psi": psi}, exact=True) == (2, 3, 4)


def test_a_chosen_point_on_a_loop_is_exact() -> None:
    """A weight on a rope of length 1 at (3/5, -4/5); none is sampled near, where x^2 + y^2 = 1."""
    fields = allowed_motions(rope_pendulum())
    point = {"x": sp.Rational(3, 5), "y": sp.Rational(-4, 5)}
    assert growth_vector(fields, point, exact=True) == (1,)
    with pytest.raises(
        InputError, match=r"satisfy constraints of position\. Give a rational state"
    ):
        growth_vector(fields, exact=True)


def trailers(count: int) -> System:
    """A unicycle that pulls trailers of length 1, each hitched to the axle before it."""
    axles = [move(length("x"), length("y")) @ rot_z(angle("psi"))]
    psi = axles[0].motions[-1].angle  # type: ignore[union-attr]
    for k in range(count):
        axles.append(axles[-1] @ rot_z(angle(f"a{k}")) @ move(-1))
    return System(
        f"trailers_{count}",
        bodies=[Body(f"axle {k}", frame) for k, frame in enumerate(axles)],
        constraints=[zero(velocity(g).y, f"axle {k}") for k, g in enumerate(axles)],
        inputs=[
            Rate("drive", on=velocity(axles[0]).x, limit=1.0),
            Rate("turn", on=psi, limit=1.0),
        ],
    )


@pytest.mark.parametrize("count", [1, 2, 3])
def test_each_trailer_takes_one_field_more(count: int) -> None:
    expected = tuple(range(2, count + 4))
    assert growth_vector(allowed_motions(trailers(count))) == expected


def test_trailers_at_right_angles_take_fibonacci_many_fields() -> None:
    """F_5 = 5 for two trailers, F_6 = 8 for three, both but the last across."""
    across = {"a0": np.pi / 2, "a1": np.pi / 2}
    two, three = allowed_motions(trailers(2)), allowed_motions(trailers(3))
    assert growth_vector(two, across) == (2, 3, 4, 4, 5)
    assert growth_vector(three, across)[-2:] == (5, 6)
    assert len(growth_vector(three, across)) == 8


@pytest.mark.parametrize(("delta", "expected"), [(0.3, (2, 3, 4, 5)), (0.0, (2, 3, 4, 4, 5))])
def test_a_car_straight_ahead_takes_a_field_more_to_choose_its_wheels_turns(
    delta: float, expected: tuple[int, ...]
) -> None:
    """Of the derived car with rolling wheels, as in tests/systems/test_growth.py."""
    assert growth_vector(allowed_motions(systems.get("car")), {"delta": delta}) == expected


# --- dynamics ---


def test_wheels_inside_a_satellite_change_no_momentum() -> None:
    """Of 12 states three follow from the angular momentum, whatever three motors do."""
    found = filtration(vector_fields(wheeled_hull()), strong=True)
    assert (found.rank, found.dimension, found.complete, found.full) == (9, 12, True, False)


@pytest.mark.parametrize(
    ("name", "expected"), [("unicycle2_v0", 5), ("rolling_disk", 6), ("acrobot_v0", 4)]
)
def test_singular_values_find_what_exact_elimination_does(name: str, expected: int) -> None:
    fields = vector_fields(systems.get(name))
    found = [filtration(fields, strong=True, exact=exact) for exact in (False, True)]
    assert found[0].growth == found[1].growth
    assert found[0].rank == expected


@pytest.mark.parametrize(
    "name",
    [
        *("rolling_disk", "diff_drive", "car", "acrobot_v0", "two_cranes", "quad2d_v0"),
        *("double_pendulum_3d", "loose_snakeboard", "kinematic_car"),
    ],
)
def test_singular_values_find_what_a_prime_field_does(name: str) -> None:
    """Exact arithmetic of another kind; where not all is spanned, of one layer more."""
    fields = vector_fields(TEST_MACHINES[name]() if name in TEST_MACHINES else systems.get(name))
    found = filtration(fields, strong=True)
    growth = found.growth if found.full else (*found.growth, found.rank)
    assert growth_over_primes(fields, len(growth)) == growth


def test_the_wheels_of_a_differential_drive_tell_its_heading() -> None:
    """r (phi_r - phi_l) - b psi stays, so that six of seven states are reached."""
    found = filtration(vector_fields(systems.get("diff_drive")), strong=True)
    assert (found.rank, found.dimension, found.complete) == (6, 7, True)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.long if n == "marionette" else ())
        for n in registered.NAMES
    ],
)
def test_ranks_leave_a_clear_gap(name: str) -> None:
    """What counts is a thousand times the tolerance of 1e-8, what does not is rounding.

    Where the wheels' turn goes last, through four brackets, it hardly goes: that a motorcycle and a
    bicycle reach everything rests on a share of 1e-8 and 1e-7. So does that a puppet does, whose
    strings are light beside its torso.
    """
    thin = {"motorcycle": 1e-8, "whipple": 1e-7, "marionette": 1e-7}
    for rank in filtration(vector_fields(registered.MAKERS[name]()), strong=True).margins:
        assert rank.smallest > thin.get(name, 1e-5)
        assert rank.largest_ignored < 1e-14


def test_inputs_that_do_not_enter_linearly_become_states() -> None:
    """The steering angle of dynobench's car: with it and the speed there are six states."""
    fields = vector_fields(systems.get("car1_v0"))
    assert fields.prolonged
    assert fields.names == ("x", "y", "theta_0", "theta_1", "v", "phi")
    assert filtration(fields, strong=True).full


def test_a_search_that_is_too_much_work_says_so() -> None:
    found = filtration(vector_fields(systems.get("quad3d_v0")), strong=True, work=2_000_000)
    assert not found.complete
    assert found.full_or_unknown


# --- wrong questions ---


def test_an_unknown_variable_is_refused_with_the_nearest() -> None:
    with pytest.raises(
        UnknownNameError, match=r"no variable is called 'psy'\. Did you mean 'psi'\?"
    ):
        growth_vector(allowed_motions(systems.get("rolling_disk")), {"psy": 1.0})


def test_constraints_that_depend_on_inputs_have_no_distribution() -> None:
    with pytest.raises(InputError, match="its constraints depend on inputs"):
        allowed_motions(systems.get("car1_v0"))


def test_what_is_irrational_has_no_exact_rank() -> None:
    fields = of((1, 0, sp.exp(x)), (0, 1, 0))
    with pytest.raises(InputError, match="exact rank: exp"):
        growth_vector(fields, {"x": 1}, exact=True)
