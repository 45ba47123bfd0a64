"""Every mistake in a machine's description is reported, with these words, and all at once."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import sympy as sp

import kinolab.systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Coulomb,
    Force,
    Potential,
    Pull,
    SlidingFriction,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    closed,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.errors import InputError

X, Y, TH = length("x"), length("y"), angle("th")
BLADE = move(X, Y) @ rot_z(TH)
MASS = parameter("m", 2.0, "kg")


def ball(name: str = "ball", **changes: Any) -> Body:
    return Body(name, BLADE, **({"mass": 1, "inertia": 0.1} | changes))


def mistakes_of(*bodies: Body, **parts: Any) -> list[str]:
    with pytest.raises(InputError) as caught:
        System("sledge", bodies=bodies or [ball()], **parts)
    return [str(mistake) for mistake in caught.value.mistakes]


def derivation_mistake(*constraints: Any, **parts: Any) -> str:
    system = System("sledge", bodies=[ball()], constraints=constraints, **parts)
    with pytest.raises(InputError) as caught:
        system.model()
    return str(caught.value)


EDGE = zero(velocity(BLADE).y, "edge")
GET_PENDULUM = partial(kinolab.systems.get, "pendulum")


def test_two_bodies_of_one_name() -> None:
    assert mistakes_of(ball(), ball()) == [
        "body 'ball': 2 have this name. Give each a name of its own."
    ]


def test_two_coordinates_of_one_name() -> None:
    assert mistakes_of(Body("b", move(X, length("x")), mass=1)) == [
        "name 'x': 2 coordinates have this name. Give each a name of its own.",
        "name 'x_dot': 2 rates have this name. Give each a name of its own.",
    ]


def test_a_parameter_named_like_a_rate() -> None:
    assert mistakes_of(ball(mass=parameter("x_dot", 1))) == [
        "name 'x_dot': a rate and a parameter have this name. Give each a name of its own."
    ]


def test_two_parameters_of_one_name() -> None:
    inertia = parameter("m", 1.0, "kg m^2")
    assert mistakes_of(ball(mass=MASS, inertia=inertia)) == [
        "name 'm': 2 parameters have this name. Give each a name of its own."
    ]


def test_an_input_named_like_a_coordinate_or_another() -> None:
    body = ball()
    inputs = [Torque(n, on=body, about=WORLD.z, limit=1) for n in ("x", "t", "t")]
    assert mistakes_of(body, inputs=inputs) == [
        "name 'x': a coordinate and an input have this name. Give each a name of its own.",
        "name 't': 2 inputs have this name. Give each a name of its own.",
    ]


@pytest.mark.parametrize(
    "parts",
    [
        {"bodies": [Body("b", move(X, sp.Symbol("s")), mass=1)]},
        {"bodies": [ball()], "constraints": [zero(rate(X) * sp.Symbol("s"), "c")]},
        {"bodies": [ball()], "gravity": toward("-z", sp.Symbol("s"))},
        {"bodies": [ball(shape=Sphere(sp.Symbol("s")))]},
        {
            "bodies": [ball()],
            "inputs": [Force("F", on=ball(), along=rot_x(sp.Symbol("s")).y, limit=1)],
        },
    ],
    ids=["frame", "constraint", "gravity", "shape", "axis"],
)
def test_an_undeclared_symbol_anywhere(parts: Any) -> None:
    with pytest.raises(InputError) as caught:
        System("sledge", **parts)
    assert str(caught.value.mistakes[0]) == (
        "system 'sledge': the symbol s is not declared. "
        "Make it with length, angle, rotation, parameter, rate or state."
    )


def test_an_undeclared_symbol_in_a_mass() -> None:
    assert (
        "system 'sledge': the symbol s is not declared. "
        "Make it with length, angle, rotation, parameter, rate or state."
    ) in mistakes_of(ball(mass=sp.Symbol("s")))


def test_no_bodies() -> None:
    with pytest.raises(InputError) as caught:
        System("empty", bodies=[])
    assert str(caught.value) == "system 'empty': it has no bodies."


def test_a_negative_mass() -> None:
    expected = ["body 'ball': its mass is -2 kg. A mass is 0 or positive."]
    assert mistakes_of(ball(mass=-2)) == expected
    assert mistakes_of(ball(mass=-MASS)) == expected
    assert mistakes_of(ball(mass=MASS), values={"m": -2.0}) == expected


@pytest.mark.parametrize("moments", [(1, 1, 3), (3, 1, 1), (1, 3, 1)])
def test_moments_that_no_body_has(moments: Any) -> None:
    assert mistakes_of(ball(inertia=moments)) == [
        "body 'ball': no rigid body has the principal moments 1, 1, 3 kg m^2. "
        "Each must be at least 0 and at most the sum of the other two."
    ]


def test_a_negative_moment() -> None:
    (mistake,) = mistakes_of(ball(inertia=-1))
    assert mistake.startswith("body 'ball': no rigid body has the principal moments -1, -1, -1")


def test_a_thin_plate_is_a_rigid_body() -> None:
    System("sledge", bodies=[ball(inertia=(0.1, 0.2, 0.1 + 0.2))])
    System("sledge", bodies=[ball(inertia=(0, 1, 1))])


def test_a_mass_that_depends_on_a_coordinate() -> None:
    assert mistakes_of(ball(mass=1 + X**2)) == [
        "body 'ball': its mass or inertia depends on more than numbers and parameters."
    ]


@pytest.mark.parametrize("mass", [math.nan, math.inf])
def test_a_mass_that_is_not_finite(mass: float) -> None:
    with pytest.raises(InputError) as caught:
        mistakes_of(ball(mass=mass))
    assert len(caught.value.mistakes) == 1


@pytest.mark.parametrize("moment", [math.nan, math.inf])
def test_a_moment_that_is_not_finite(moment: float) -> None:
    with pytest.raises(InputError) as caught:
        mistakes_of(ball(inertia=moment))
    assert len(caught.value.mistakes) == 1


def test_two_moments_are_not_three() -> None:
    with pytest.raises(InputError):
        System("sledge", bodies=[ball(inertia=(1, 1))])


def test_a_frame_that_depends_on_a_rate() -> None:
    """A pose is a function of the coordinates; a rate in it would be left out of its velocity."""
    with pytest.raises(InputError):
        System("s", bodies=[Body("b", move(X + rate(X)), mass=1)]).model()


def test_gravity_that_depends_on_a_coordinate() -> None:
    """A uniform field has one strength; forces and potential would contradict each other."""
    with pytest.raises(InputError):
        System("s", bodies=[ball()], gravity=toward("-x", 1 + X**2)).model()


def test_a_shape_that_depends_on_a_coordinate() -> None:
    with pytest.raises(InputError):
        System("s", bodies=[ball(shape=Sphere(1 + X**2))])


@pytest.mark.parametrize("radius", [-1.0, math.nan])
def test_a_shape_of_impossible_size(radius: float) -> None:
    with pytest.raises(InputError):
        System("s", bodies=[ball(shape=Sphere(radius))])


def test_a_shape_farther_away_than_rounding_allows() -> None:
    for shape, what in ((Sphere(1e300), "radius"), (Sphere(1.0, at=(0, -1e300, 0)), "at")):
        (mistake,) = mistakes_of(ball(shape=shape))
        assert f"body 'ball' sphere: {what} is " in mistake
        assert mistake.endswith("1e+300 m. Stay within 1e+09 m.")


def test_an_input_on_a_body_of_another_machine() -> None:
    stranger = Body("stranger", move(X), mass=1)
    assert len(mistakes_of(inputs=[Force("F", on=stranger, along=WORLD.x, limit=1)])) == 1
    body = ball()
    push = Force("F", on=body, along=WORLD.x, reacts_on=stranger, limit=1)
    assert len(mistakes_of(body, inputs=[push])) == 1


def test_an_unknown_parameter() -> None:
    assert mistakes_of(ball(mass=MASS), values={"n": 1.0}) == [
        "system 'sledge': no parameter is called 'n'. Known: m."
    ]


def test_an_unknown_parameter_of_a_copy_is_a_mistake_too() -> None:
    """As documented by with_parameters and by kinolab.systems.get."""
    for make in (kinolab.systems.get("pendulum").with_parameters, GET_PENDULUM):
        with pytest.raises(InputError, match="no parameter is called 'mass'"):
            make(mass=2.0)


def test_a_parameter_that_is_no_number() -> None:
    assert mistakes_of(ball(mass=MASS), values={"m": math.nan}) == [
        "parameter 'm': its value is nan. Give a number."
    ]


def test_a_parameter_that_is_text_is_not_evaluated() -> None:
    """SymPy would evaluate it as code."""
    evil: Any = "1/0"
    with pytest.raises(InputError, match="parameter 'm': its value is '1/0'"):
        System("sledge", bodies=[ball(mass=MASS)], values={"m": evil})
    done: list[int] = []
    import builtins

    builtins.kinolab_probe = done.append  # type: ignore[attr-defined]
    try:
        code: Any = "__import__('builtins').kinolab_probe(1)"
        with pytest.raises((InputError, sp.SympifyError, AttributeError, TypeError)):
            System("sledge", bodies=[ball(mass=MASS)], values={"m": code})
    finally:
        del builtins.kinolab_probe  # type: ignore[attr-defined]
    assert not done, "the text was run as code"


@pytest.mark.parametrize("value", [np.float64(3), np.float32(3), np.int64(3), 3])
def test_a_number_of_numpy_is_a_number(value: Any) -> None:
    system = System("sledge", bodies=[ball(mass=MASS)], values={"m": value})
    assert system.number(MASS * 2) == 6.0


def test_a_coordinate_that_is_not_listed() -> None:
    assert mistakes_of(coordinates=[X, Y]) == [
        "system 'sledge': the coordinate th is used but not listed in coordinates."
    ]


def test_a_velocity_that_is_no_coordinate_of_the_machine() -> None:
    assert mistakes_of(velocities=[length("w")], constraints=[EDGE]) == [
        "system 'sledge': w is named in velocities but is no coordinate of the machine."
    ]


def test_a_velocity_that_is_named_twice() -> None:
    with pytest.raises(InputError):
        System("s", bodies=[ball()], constraints=[EDGE], velocities=[X, X]).model()


def test_too_few_velocities() -> None:
    assert derivation_mistake(EDGE, velocities=[TH]) == (
        "system 'sledge': 1 velocities are named; 2 are independent."
    )


def test_velocities_that_do_not_describe_the_motion() -> None:
    """y_dot cannot follow from x_dot = 0."""
    assert derivation_mistake(zero(rate(X), "rail"), velocities=[X, TH]) == (
        "system 'sledge': the velocities that are named do not determine y_dot. Is a constraint "
        "missing there, or does it hold another point? Else name others, or leave velocities out."
    )


def test_several_mistakes_are_reported_together() -> None:
    found = mistakes_of(
        ball("a", mass=-1),
        ball("a", inertia=(1, 1, 5)),
        ball("c", mass=1 + X),
        values={"k": 2.0},
        coordinates=[X, Y],
    )
    assert len(found) == 6
    for part in ("body 'a': 2 have", "mass is -1", "moments 1, 1, 5", "'c'", "'k'", "th is used"):
        assert any(part in mistake for mistake in found), part


# What only the derivation can see


def test_a_constraint_that_never_bites() -> None:
    assert derivation_mistake(zero(0 * rate(X), "idle")) == (
        "constraint 'idle': no rate occurs in it. State a velocity, such as V.y or rate(x)."
    )
    assert derivation_mistake(zero(velocity(BLADE).z, "flat")) == (
        "constraint 'flat': no rate occurs in it. State a velocity, such as V.y or rate(x)."
    )


@pytest.mark.parametrize("velocity_", [rate(X) ** 2, rate(X) * rate(Y), sp.sin(rate(X))], ids=str)
def test_a_constraint_that_is_not_linear(velocity_: Any) -> None:
    assert derivation_mistake(zero(velocity_, "odd")) == (
        "constraint 'odd': it is not linear in the rates. State a velocity, such as V.y or rate(x)."
    )


@pytest.mark.parametrize("friction", [Viscous(X, 1), Coulomb(X, 1), SlidingFriction((X, TH), 1)])
def test_friction_of_what_is_no_velocity_which_would_act_on_nothing(friction: Any) -> None:
    (mistake,) = mistakes_of(efforts=[friction])
    assert mistake.partition(" friction of ")[2] in {
        f"{of}: no rate occurs in it. Write rate(x) for the velocity of a coordinate x, or a "
        "velocity such as V.x."
        for of in ("x", "x and th")
    }


def test_friction_of_what_is_not_linear() -> None:
    system = System("sledge", bodies=[ball()], efforts=[Viscous(rate(X) ** 2, 1)])
    with pytest.raises(InputError) as caught:
        system.model()
    assert str(caught.value) == (
        "viscous friction of x_dot**2: it is not linear in the rates. "
        "State a velocity, such as V.y or rate(x)."
    )


def test_friction_against_what_moves_is_none_of_these() -> None:
    belt = System("sledge", bodies=[ball()], efforts=[Viscous(rate(X) - 1.0, 3.0)])
    model = belt.model()
    at_rest = model.f(np.zeros(model.nx), np.zeros(0))
    assert at_rest[model.nq] == pytest.approx(3.0)  # [m/s^2]: 3 N s/m on 1 kg, from 1 m/s


def test_an_energy_or_a_loop_of_velocities() -> None:
    assert mistakes_of(efforts=[Potential(rate(X) ** 2)]) == [
        "potential: its energy depends on the velocity x_dot. "
        "Give a function of coordinates; a Wrench takes the rest."
    ]
    assert mistakes_of(constraints=[closed(rate(X), "held")]) == [
        "constraint 'held': it depends on the velocity x_dot. "
        "closed() takes a function of coordinates, zero() a velocity."
    ]


@pytest.mark.parametrize("velocity_", [X, rate(X) - 1, rate(X) + sp.cos(TH)], ids=str)
def test_a_constraint_that_rest_does_not_satisfy(velocity_: Any) -> None:
    assert derivation_mistake(zero(velocity_, "moving")) == (
        "constraint 'moving': it does not vanish when the machine rests. "
        "State a velocity, such as V.y or rate(x)."
    )


def test_a_redundant_constraint_is_left_out_and_named() -> None:
    def redundant(*constraints: Any) -> tuple[str, ...]:
        return System("sledge", bodies=[ball()], constraints=constraints).model().redundant

    assert redundant(EDGE, zero(2 * velocity(BLADE).y, "again")) == ("again",)
    both = [zero(rate(X) - rate(Y), "a"), zero(rate(Y) - rate(TH), "b")]
    assert redundant(*both, zero(rate(X) - rate(TH), "c")) == ("c",)
    assert redundant(*both) == ()


def test_a_rope_between_two_frames_with_one_origin_has_no_direction() -> None:
    body = ball()
    rope = Pull("rope", between=(BLADE, body.frame), limit=1)
    with pytest.raises(InputError) as caught:
        System("sledge", bodies=[body], inputs=[rope]).model()
    assert str(caught.value) == (
        "system 'sledge': it is singular everywhere: an expression divides by zero."
    )


def test_a_pole_of_the_coordinates_at_rest_is_no_missing_mass() -> None:
    """A spherical pendulum that hangs straight down has no mass about its own axis."""
    swing, turn = angle("swing"), angle("turn")
    bob = Body("bob", rot_z(turn) @ rot_x(swing) @ move(0, 0, -1), mass=1.0)
    assert System("s", bodies=[bob]).model().nx == 4


def test_a_direction_without_mass() -> None:
    hinge = angle("hinge")
    bob = Body("bob", move(X) @ rot_z(hinge), mass=1)
    with pytest.raises(InputError) as caught:
        System("s", bodies=[bob]).model()
    assert str(caught.value) == (
        "system 's': no mass or inertia resists a motion of hinge. It turns 'bob' "
        "about its own centre only: give it an inertia, or mind the order of its frame's factors, "
        "as in rot_y(q) @ move(…), which swings it."
    )


def test_two_coordinates_that_move_the_same_mass_the_same_way() -> None:
    p, q = length("p"), length("q")
    with pytest.raises(InputError, match=r"a motion of p, q\."):
        System("s", bodies=[Body("b", move(p) @ move(q), mass=1)]).model()


def test_a_coordinate_that_moves_nothing() -> None:
    spare = length("spare")
    with pytest.raises(InputError, match=r"the coordinate spare moves nothing\."):
        System("s", bodies=[ball()], coordinates=[X, Y, TH, spare])


def test_a_machine_that_cannot_move_is_no_crash() -> None:
    """Without coordinates there is nothing to plan: an InputError, or a model of size 0."""
    system = System("rock", bodies=[Body("b", move(1.0), mass=1)])
    try:
        model = system.model()
    except InputError as error:
        assert "rock" in str(error)  # noqa: PT017
    else:
        assert model.nx == 0
