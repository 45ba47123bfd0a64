"""Speeds that are inputs, in machines with modes: what is refused is said in the author's words."""

from __future__ import annotations

import pytest

from kinolab.dynamics import (
    Body,
    Drive,
    Mode,
    Rate,
    State,
    System,
    Transition,
    force_of,
    length,
    move,
    rate,
    zero,
)
from kinolab.dynamics.language.inputs import Input
from kinolab.errors import InputError

X, Y = length("x"), length("y")


def clamp(drive: Input | State) -> System:
    """Return a cart that is held until somebody pulls, beside a slide."""
    held = zero(rate(X), "held")
    return System(
        "clamp",
        bodies=[Body("cart", move(X, 0, 0), mass=1.0), Body("slide", move(X, Y, 0), mass=1.0)],
        inputs=[drive] if isinstance(drive, Input) else [],
        states=[drive] if isinstance(drive, State) else [],
        modes=[Mode("shut", constraints=[held]), Mode("open")],
        transitions=[Transition("let go", "shut", "open", until=force_of(held) + 1)],
    )


@pytest.mark.parametrize("word", [
    Rate("pace", on=Y, limit=1.0),
    State("pace", 0.0, velocity=rate(Y), limits=(-1.0, 1.0)),
], ids=["input", "state"])  # fmt: skip
def test_a_speed_beside_masses_and_modes_is_refused_by_its_name(word: Input | State) -> None:
    with pytest.raises(InputError) as caught:
        clamp(word).model()
    said = str(caught.value)
    assert said.startswith("system 'clamp' ")
    assert "'pace': it sets a speed" in said
    assert "all" not in said  # which nobody wrote


def test_the_way_on_that_is_named_leads_on() -> None:
    model = clamp(Drive("push", on=Y, limit=1.0)).model()
    assert model.nu == 1
