"""Decoupling vector fields against those that the sources give in closed form.

Sources:
    Bullo, Lynch, Kinematic controllability for decoupled trajectory planning in underactuated
        mechanical systems, IEEE Trans. Robotics and Automation 17(4), 2001: a planar body, and an
        arm whose third joint is passive.
    Bullo, Lewis, Kinematic controllability and motion planning for the snakeboard, IEEE Trans.
        Robotics and Automation 19(3), 2003.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Control,
    Force,
    System,
    Torque,
    Wrench,
    angle,
    filtration,
    length,
    move,
    rot_y,
    rot_z,
    toward,
)
from kinolab.dynamics.analysis.decoupling_fields import (
    DecouplingFields,
    decoupling_fields,
)
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from tests.machines import MACHINES

OFFSET, MASS, INERTIA, HALF = 0.1, 1.0, 0.02, 0.25  # SI units


def planar_body(offset: float = OFFSET) -> System:
    """A body in the plane with both forces at a point behind its centre."""
    x, y, theta = length("x"), length("y"), angle("theta")
    push, thrust = Control("push", limit=1.0, unit="N"), Control("thrust", limit=1.0, unit="N")
    hull = Body("hull", move(x, y) @ rot_z(theta), mass=MASS, inertia=INERTIA)
    force = Wrench(on=hull, force=(push.symbol, thrust.symbol, 0), at=(-offset, 0, 0))
    return System("planar_body", bodies=[hull], inputs=[push, thrust], efforts=[force])


def arm() -> System:
    """Three links in a horizontal plane; the third joint has no motor."""
    frame, links = WORLD, []
    for i in (1, 2, 3):
        frame = frame @ move(2 * HALF if i > 1 else 0.0) @ rot_z(angle(f"q{i}"))
        links.append(Body(f"link{i}", frame @ move(HALF), mass=MASS, inertia=INERTIA))
    motors = [
        Torque("tau1", on=links[0], about=WORLD.z, limit=5.0),
        Torque("tau2", on=links[1], about=WORLD.z, reacts_on=links[0], limit=5.0),
    ]
    return System("arm", bodies=links, inputs=motors)


def cart_pole() -> System:
    """A pendulum on a cart, under gravity."""
    x, sway = length("x"), angle("sway")
    cart = Body("cart", move(x), mass=1.0, shape=Box(0.2, 0.1, 0.1))
    bob = Body("bob", move(x) @ rot_y(sway) @ move(0, 0, -0.5), mass=0.2)
    push = Force("push", on=cart, along=WORLD.x, limit=5.0)
    return System("cart_pole", bodies=[cart, bob], inputs=[push], gravity=toward("-z", 9.81))


def rates(found: DecouplingFields) -> Iterator[tuple[dict[str, float], dict[str, Array]]]:
    """Yield random configurations with q_dot (nq,) along every field."""
    generator = np.random.default_rng(3)
    for _ in range(10):
        q = {name: float(generator.uniform(-1.2, 1.2)) for name in found.fields.names}
        values = {**found.fields.values, **q}
        fields = found.fields.inputs
        yield q, {n: np.array(found.fields.tape.evaluate(f, values)) for n, f in fields.items()}


def test_the_snakeboard_has_its_two_published_fields() -> None:
    """One steers; the other turns the rotor with the steering held, so that no momentum changes.

    The wheels' spin, which the source leaves out, acts as a mass on the speed of rolling.
    """
    found = decoupling_fields(systems.get("snakeboard"))
    assert found.names == ("psi", "phi")
    assert found.moved["phi"] == ("phi",)
    p = found.fields.values
    mass = p["m"] + p["I_s"] / 0.04**2
    for q, fields in rates(found):
        phi, theta = q["phi"], q["theta"]
        forward = p["J_r"] * np.sin(phi) * np.cos(phi) / (mass * p["l"])
        turn = -p["J_r"] * np.sin(phi) ** 2 / (mass * p["l"] ** 2)
        along = [forward * np.cos(theta), forward * np.sin(theta), turn]
        expected = [*along, 1.0, 0.0, forward / np.cos(phi) / 0.04]
        np.testing.assert_allclose(fields["psi"], expected, atol=1e-12)
        np.testing.assert_allclose(fields["phi"], [0, 0, 0, 0, 1, 0], atol=1e-12)


def test_paths_along_both_lead_everywhere_and_friction_is_named() -> None:
    """The published machine has no friction; ours does, where no input makes up for it."""
    found = decoupling_fields(systems.get("snakeboard"))
    assert filtration(found.fields).growth == (2, 3, 5, 6)
    assert found.exhaustive
    assert not found.together
    assert found.damped == ("psi",)
    smooth = systems.get("snakeboard").with_parameters(c_r=0.0)
    assert decoupling_fields(smooth).damped == ()


def test_a_planar_body_moves_along_its_line_and_about_its_centre_of_percussion() -> None:
    """The second point is J / (m h) ahead of the centre: only it does not move."""
    found = decoupling_fields(planar_body())
    assert set(found.names) == {"push", "thrust"}
    for q, fields in rates(found):
        heading = np.array([np.cos(q["theta"]), np.sin(q["theta"])])
        across = np.array([-heading[1], heading[0]])
        *straight, spin = fields["push"] / np.linalg.norm(fields["push"])
        np.testing.assert_allclose(np.abs(straight @ heading), 1.0, atol=1e-12)
        assert abs(spin) < 1e-12
        *moved, turn = fields["thrust"]
        ahead = INERTIA / (MASS * OFFSET)
        np.testing.assert_allclose(moved + turn * ahead * across, 0.0, atol=1e-12)
    assert filtration(found.fields).full


def test_forces_at_the_centre_of_mass_can_be_combined_but_turn_nothing() -> None:
    found = decoupling_fields(planar_body(0.0))
    assert found.together
    assert filtration(found.fields).rank == 2  # of 3 dimensions


def test_an_arm_with_a_passive_joint_has_the_two_fields_of_its_last_link() -> None:
    """The link moves along itself, or turns about its centre of percussion.

    That is (J + m c^2) / (m c) from its joint, where c is the distance of the centre of mass.
    """
    found = decoupling_fields(arm())
    assert len(found.names) == 2
    assert found.exhaustive
    percussion = (INERTIA + MASS * HALF**2) / (MASS * HALF)
    for q, fields in rates(found):
        angles = np.cumsum([q["q1"], q["q2"], q["q3"]])
        link = np.array([np.cos(angles[2]), np.sin(angles[2])])
        across = np.array([-link[1], link[0]])
        kinds = []
        for velocities in fields.values():
            spins = np.cumsum(velocities)
            joint = (
                2
                * HALF
                * sum(
                    spin * np.array([-np.sin(a), np.cos(a)])
                    for spin, a in zip(spins[:2], angles[:2], strict=True)
                )
            )
            slides = abs(spins[2]) < 1e-9 and abs(joint @ across) < 1e-9
            turns = np.abs(joint + spins[2] * percussion * across).max() < 1e-9
            kinds.append((slides, turns))
        assert sorted(kinds) == [(False, True), (True, False)]


@pytest.mark.parametrize(
    ("machine", "reason"),
    [
        (cart_pole, "gravity or springs push it where no input does"),
        (lambda: systems.get("falling_disk"), "it has feedback or states of its own"),
        (MACHINES["kinematic_car"], "its inputs are velocities already"),
        (MACHINES["finned_hull"], "what its inputs do depends on its velocity"),
    ],
)
def test_machines_to_which_the_notion_does_not_apply_are_refused(
    machine: Callable[[], System], reason: str
) -> None:
    with pytest.raises(InputError, match=reason):
        decoupling_fields(machine())


def test_many_joints_are_refused_before_their_inputs_are_chosen_from() -> None:
    """Of 26 velocities there are ten million choices of 13; gravity speaks against all of them."""
    bodies, inputs = [], []
    for k in range(13):
        x, q = length(f"x{k}"), angle(f"q{k}")
        cart = Body(f"cart{k}", move(x), mass=1.0)
        bob = Body(f"bob{k}", cart.frame @ rot_y(q) @ move(0, 0, -0.5), mass=0.3)
        bodies += [cart, bob]
        inputs.append(Force(f"push{k}", on=cart, along=WORLD.x, limit=10.0))
    carts = System("carts", bodies=bodies, inputs=inputs, gravity=toward("-z", 9.81))
    with pytest.raises(InputError, match="gravity or springs push it where no input does"):
        decoupling_fields(carts)
