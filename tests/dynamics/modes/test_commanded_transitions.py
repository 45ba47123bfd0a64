"""Transitions that inputs decide, such as a hand that opens on command, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics import (
    Body,
    Control,
    Mode,
    Model,
    System,
    Transition,
    length,
    move,
    rate,
    require,
    toward,
    zero,
)
from kinolab.errors import InputError
from kinolab.simulation.reference import follow

G, SPEED = 9.81, 0.5  # [m/s^2]; [m/s] of the cart


def dropper() -> System:
    """A cart that rolls on, and a load that hangs until it is let go beyond 0.3 m."""
    x, z = length("x"), length("z", -20.0, 20.0)
    hand = Control("hand", limit=1.0)
    return System(
        "dropper",
        bodies=[Body("cart", move(x, 0, 0), mass=1.0), Body("load", move(0, 0, z), mass=1.0)],
        inputs=[hand],
        gravity=toward("-z", G),
        modes=[Mode("held", constraints=[zero(rate(z), "hangs")]), Mode("free")],
        transitions=[
            Transition("drop", "held", "free", until=0.5 - hand.symbol, provided=x - 0.3),
            Transition("catch", "free", "held", until=0.5 + hand.symbol),
        ],
    )


def both(model: Model, u: list[float]) -> np.ndarray:
    """The states after each second, from rest with a rolling cart: by steps, by the reference."""
    x, t = np.array([0.0, 0.0, SPEED, 0.0, 0.0]), np.arange(len(u) + 1.0)
    held = np.array(u)[:, None]
    return np.array(
        [model.steps(x, held, np.diff(t)), follow(model, x, t, held, np.ones(model.nx)).x]
    )


def test_it_falls_from_the_instant_at_which_command_and_condition_hold() -> None:
    """The cart is beyond 0.3 m after 0.6 s of the step in which the hand opens; caught at 2 s."""
    for states in both(dropper().model(), [1.0, 1.0, -1.0]):
        for k, fallen in ((1, 0.4), (2, 1.4)):  # [s]
            expected = [SPEED * k, -G * fallen**2 / 2, SPEED, -G * fallen, 1.0]
            assert states[k] == pytest.approx(expected, abs=1e-9)
        assert states[3] == pytest.approx([1.5, -G * 1.4**2 / 2, SPEED, 0.0, 0.0], abs=1e-9)


def test_it_falls_when_the_hand_opens_where_the_condition_holds_already() -> None:
    for states in both(dropper().model(), [0.0, 1.0]):
        assert states[1] == pytest.approx([0.5, 0.0, SPEED, 0.0, 0.0], abs=1e-9)
        assert states[2] == pytest.approx([1.0, -G / 2, SPEED, -G, 1.0], abs=1e-9)


def test_an_input_that_only_a_requirement_asks_is_one_too() -> None:
    hand, z = Control("hand", limit=1.0), length("z")
    made = System(
        "asked",
        bodies=[Body("load", move(0, 0, z), mass=1.0)],
        inputs=[hand],
        modes=[Mode("flight"), Mode("stop", constraints=[zero(rate(z), "stopped")])],
        transitions=[Transition("stop", "flight", "stop", until=z)],
        requirements=[require(z + hand.symbol, "command")],
    )
    assert made.model().nu == 1


def test_an_input_that_nothing_asks_is_refused() -> None:
    machine = dropper()
    with pytest.raises(InputError, match="reaches nothing in any mode, and no transition asks"):
        machine.changed(inputs=[*machine.inputs, Control("spare", limit=1.0)]).model()
