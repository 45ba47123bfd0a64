"""Symmetries and conserved momenta that are described, against what machines do."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab import systems
from kinolab.analyze.describe.conserved import conserved_momenta, cyclic_coordinates_of
from kinolab.analyze.describe.description import describe
from kinolab.analyze.describe.description_text import described_as_text
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Drive,
    Rope,
    System,
    Torque,
    angle,
    length,
    move,
    rot_y,
    toward,
)


def swinging_cart() -> System:
    """A cart on a free rail; a motor between cart and bob moves both."""
    x, theta = length("x", speed=5.0), angle("theta", speed=5.0)
    shape = Box(0.1, 0.1, 0.1)
    cart = Body("cart", move(x, 0, 0), mass=1.0, shape=shape)
    hinge = move(x, 0, 0) @ rot_y(theta)
    bob = Body("bob", hinge @ move(0, 0, -0.5), mass=0.3, inertia=0.01, shape=shape)
    motor = Torque("motor", on=bob, reacts_on=cart, about=hinge.y, limit=1)
    return System("swing", bodies=[cart, bob], gravity=toward("-z", 9.81), inputs=[motor])


def test_a_conserved_momentum_stays_as_it_is_in_a_simulation() -> None:
    """Along x no force acts, whatever the motor does; along theta gravity and the motor do."""
    system = swinging_cart()
    assert conserved_momenta(system) == ("x",)
    assert cyclic_coordinates_of(system) == ("x",)
    model, generator = system.model(), np.random.default_rng(0)
    x = np.array([0.1, 0.7, 0.4, -0.3])
    momenta = []
    for _ in range(200):
        momenta.append(model.mass_matrix(x) @ model.velocity(x))
        x = model.step(x, generator.uniform(-1.0, 1.0, 1), 0.005)
    changes = np.ptp(momenta, axis=0)  # [kg m/s] and [kg m^2/s]
    assert changes[0] < 1e-7
    assert changes[1] > 1e-2


def test_a_driven_symmetry_is_cyclic_but_conserves_nothing() -> None:
    """The trolley of a crane may stand anywhere, but its motor and drag push it."""
    crane = systems.get("crane")
    assert {"x", "y"} <= set(cyclic_coordinates_of(crane))
    assert conserved_momenta(crane) == ()


def test_a_winch_without_mass_conserves_nothing() -> None:
    """Its input decides how fast it turns, and no momentum could stay as it is."""
    z, reel = length("z"), length("l", 0.5, 3.0)
    stone = Body("stone", move(0, 0, z), mass=2.0)
    rope = Rope(between=(WORLD, stone.frame), stiffness=5000.0, length=reel)
    winch = Drive("reel", on=reel, limit=1.0)
    hung = System("hung", bodies=[stone], gravity=toward("-z"), inputs=[winch], efforts=[rope])
    assert conserved_momenta(hung) == ()


@pytest.mark.parametrize("pairs", [[], [("cart", "bob")]])
def test_the_pairs_that_may_not_touch_are_listed(pairs: list[tuple[str, str]]) -> None:
    text = described_as_text(describe(swinging_cart().changed(collisions=tuple(pairs))))
    wanted = "cart and bob" if pairs else "none; bodies may pass through each other"
    assert f"pairs that must not touch: {wanted}" in text
