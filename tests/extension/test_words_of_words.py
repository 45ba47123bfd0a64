"""Forces and inputs from outside may consist of other words; whatever else they say is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from kinolab.dynamics import (
    Body,
    Coulomb,
    Force,
    Load,
    Potential,
    Rope,
    Spring,
    System,
    Viscous,
    Wrench,
    length,
    move,
    parameter,
    rate,
)
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.language.quantities import Change, apart, place
from kinolab.errors import InputError

MASS = 0.5  # [kg]
X = length("x", -3.0, 3.0, speed=5.0)
CART = Body("cart", move(X), mass=MASS)
HOOK = move(0, 0, 1)
REACH = 1.25**0.5  # [m] from the hook where x is 0.5 m


@dataclass(frozen=True)
class Own(Effort):
    """A force that is what it is given; a function makes it."""

    consists_of: Any

    def lowered(self) -> Any:
        """Return it."""
        made = self.consists_of
        return made() if callable(made) else made


@dataclass(frozen=True)
class OwnInput(Input):
    """An input that is what it is given."""

    limit: Any
    consists_of: Any

    def lowered(self) -> Any:
        """Return it."""
        return self.consists_of


def cart(*efforts: Effort, inputs: tuple[Input, ...] = ()) -> System:
    return System("cart", bodies=[CART], efforts=efforts, inputs=inputs)


def push(name: str = "push", limit: float = 2.0) -> Force:
    return Force(name, on=CART, along=CART.frame.x, limit=limit)


@pytest.mark.parametrize(
    ("word", "force"),
    [
        (Wrench(on=CART, force=(-32, 0, 0)), -32.0),
        (Spring(between=(HOOK, CART.frame), stiffness=7), -7 * 0.5),
        (Viscous(rate(X), 3), -3 * 1.5),
        (Coulomb(rate(X), 4), -4.0),
        (Rope(between=(HOOK, CART.frame), stiffness=7, length=1), -7 * (REACH - 1) * 0.5 / REACH),
        (Own((Own((Potential(9 * X),)), Load(1, rate(X)))), -8.0),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_force_of_forces_is_these(word: Effort, force: float) -> None:
    """At x = 0.5 m and 1.5 m/s; its file has the same."""
    system = cart(Own((word,)))
    x = np.array([0.5, 1.5])
    for machine in (system, System.of(machine_from_json(machine_to_json(system)))):
        assert machine.model().f(x)[1] == pytest.approx(force / MASS, rel=1e-9)


def test_an_input_of_an_input_and_friction_is_these() -> None:
    geared = OwnInput("push", 2.0, (push(), Viscous(rate(X), 3)))
    system = cart(inputs=(geared,))
    for machine in (system, System.of(machine_from_json(machine_to_json(system)))):
        found = machine.model().f([0, 1.5], [0.7])
        assert found[1] == pytest.approx((0.7 - 4.5) / MASS, rel=1e-12)


def test_what_is_compiled_has_a_place_of_its_own_in_the_cache() -> None:
    """Also where files could not tell it from another machine."""
    gap = apart(HOOK, CART.frame)
    framed, plain = Own((Potential(gap**2),)), Potential(1 + X**2)
    keys = {cart(word).model().key for word in (framed, plain, Own((plain,)))}
    assert len(keys) == 2


def test_loads_of_quantities_need_no_class() -> None:
    speed = Change(apart(HOOK, CART.frame))
    found = cart(Load(-2 * speed, speed)).model().f([0.5, 1.5])
    slope = 0.5 / REACH
    assert found[1] == pytest.approx(-2 * slope**2 * 1.5 / MASS, rel=1e-12)


def test_what_only_the_lowered_force_mentions_is_found() -> None:
    k = parameter("k", 6.0, "N/m")
    system = cart(Own(lambda: [Potential(k * X**2 / 2)]))
    assert system.parameters == (k,)
    assert system.model().f([0.5, 0.0])[1] == pytest.approx(-6 * 0.5 / MASS)


def endless() -> Any:
    return (Own(endless),)


WRONG: dict[str, Any] = {
    "its lowered() returned None.": None,
    "its lowered() returned 3.0.": lambda: 3.0,
    "its lowered() returned 'drag'.": "drag",
    "its lowered() returned ['drag'].": lambda: ["drag"],
    "its lowered() returned Load(magnitude=-3*x_dot, velocity=x_dot).": Load(-3 * rate(X), rate(X)),
    "its lowered() failed (ZeroDivisionError: division by zero).": lambda: 1 / 0,
    "it is lowered to itself, without end.": endless,
    "it is lowered to Control(name='push', limit=2.0, unit='N'), which is not a force.": (push(),),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_force_is_refused_with_the_name_of_its_class(what: str) -> None:
    with pytest.raises(InputError) as caught:
        cart(Own(WRONG[what]))
    remedy = "Return a list of forces, such as [Load(-k * V.x, V.x)]."
    assert str(caught.value) == f"class Own: {what} {remedy}"


@pytest.mark.parametrize(
    ("parts", "what"),
    [
        ([], "it is lowered to nothing."),
        ([push(), push("pull")], "it is lowered to Control, Load, Control, Load."),
        ([push(), Spring(between=(HOOK, CART.frame), stiffness=1)], "Control, Load, Potential."),
        ([push("pull")], "it is 'push' with the limit 2.0, and lowered to 'pull' with the limit"),
        ([push(limit=9.0)], "it is 'push' with the limit 2.0, and lowered to 'push' with the "),
    ],
)
def test_an_input_that_files_would_have_otherwise_is_refused(parts: Any, what: str) -> None:
    with pytest.raises(InputError) as caught:
        cart(inputs=(OwnInput("push", 2.0, tuple(parts)),))
    assert f"class OwnInput: {what}" in str(caught.value) or what in str(caught.value)


@dataclass
class Loose(Effort):
    """It can be changed after it has been lowered."""

    def lowered(self) -> Any:
        """Return an energy."""
        return [Potential(X**2)]


@dataclass(frozen=True)
class Drag(Effort):
    """Friction whose coefficient is looked at."""

    coefficient: float
    size = "coefficient"

    def lowered(self) -> Any:
        """Return it against the velocity."""
        return [Load(-self.coefficient * rate(X), rate(X))]


class Misspelt(Drag):
    """What is looked at does not exist."""

    size = "coeficient"


MISTAKES: dict[str, Callable[[], Any]] = {
    "class Loose: it can be changed (unhashable": lambda: cart(Loose()),
    "drag: its coefficient is -0.3. Give 0 or more": lambda: cart(Drag(-0.3)),
    "class Misspelt: its size is 'coeficient'. Name one of": lambda: cart(Misspelt(0.3)),
    "Drag coefficient: nan is neither a finite number nor": lambda: cart(Drag(float("nan"))),
    "load: no rate occurs in it. Write rate(x)": lambda: cart(Load(-0.3, X)),
    "own: no rate occurs in it. Write rate(x)": lambda: cart(Own((Load(-0.3, 2 * X),))),
    "load: no rate occurs in it. Write": lambda: cart(Load(-0.3, 0 * X)),
    "potential: its energy depends on the velocity": lambda: cart(
        Potential(Change(apart(HOOK, CART.frame)))
    ),
    "Change position: it is a MutableDenseMatrix. Give an expr": lambda: Change(place(CART.frame)),
    "efforts entry 1: it is 3. Give a force, such as": lambda: cart(3),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("said", MISTAKES)
def test_what_would_act_wrongly_or_not_at_all_is_refused(said: str) -> None:
    with pytest.raises(InputError) as caught:
        MISTAKES[said]()
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("name", "base"), [("Spring", Effort), ("Torque", Effort), ("Rate", Input)]
)
def test_a_class_with_the_name_of_a_word_is_refused(name: str, base: type) -> None:
    with pytest.raises(InputError) as caught:
        type(name, (base,), {})
    said = f"class {name}: kinolab has a word of this name. Choose another name."
    assert str(caught.value) == said
