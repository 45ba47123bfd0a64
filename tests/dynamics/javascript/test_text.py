"""Emitted text: short, kept on disk, and never more than data where users name things."""

from pathlib import Path

import numpy as np
import pytest

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_z,
    zero,
)
from kinolab.dynamics.javascript import emitted_module, javascript_of
from kinolab.dynamics.javascript.facts import as_json
from tests.dynamics.javascript.machines import MAKERS, model
from tests.javascript_engine import Engine

LONGEST = 150_000  # bytes
LONGER = {"marionette": 270_000, "panda": 200_000}  # 28 coordinates; seven, and a long law


@pytest.mark.parametrize("name", list(MAKERS))
def test_a_machine_is_short(name: str) -> None:
    assert len(javascript_of(model(name)).encode()) < LONGER.get(name, LONGEST)


def test_a_machine_is_derived_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page is written after every plan; it must not wait for a derivation again."""
    made = MAKERS["rolling_disk"]().model()
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path))
    first = javascript_of(made)
    monkeypatch.setattr(emitted_module, "derive", None)
    assert javascript_of(made) == first


def test_a_damaged_entry_is_written_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = MAKERS["pendulum"]().model()
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path))
    first = javascript_of(made)
    (entry,) = tmp_path.glob("*.js")
    entry.write_bytes(entry.read_bytes()[:-1] + b" ")
    assert javascript_of(made) == first


def test_names_stay_data(engine: Engine) -> None:
    """Bodies, constraints and units may be called anything; none of it becomes code or markup."""
    hostile = 'b"]; </script><script>globalThis.hit = 1//`${globalThis.hit = 1}`'
    x, y = length("x"), length("y")
    cart = move(x, y, 0)
    body = Body(hostile, cart, mass=parameter("m", 1.0, hostile), shape=Box(1, 1, 1))
    system = System(
        "cart",
        bodies=[body],
        constraints=[zero(rate(y), hostile)],
        inputs=[Force("push", on=body, along=cart.x, limit=1.0)],
    )
    made = system.model()
    assert "<" not in as_json({"name": hostile})
    assert as_json({"name": "\u2028"}).isascii()  # a line's end to scripts; machines refuse it, too
    assert "</script" not in javascript_of(made)
    machine = engine.machine(made)
    assert engine.run(f"return {machine}.bodies") == [hostile]
    assert engine.run(f"return {machine}.parameters[0].unit") == hostile
    assert engine.run("return typeof globalThis.hit") == "undefined"


def test_a_longer_rod_is_drawn_longer(engine: Engine) -> None:
    machine = engine.machine(model("pendulum"))
    at = engine.run(f"return {machine}.parameters.findIndex(entry => entry.name === 'l')")
    p = model("pendulum").parameter_vector(l=2.5).tolist()
    assert p[at] == 2.5
    ball, rod = engine.run(f"return {machine}.shapes(a)[0]", p)
    assert (rod["kind"], rod["axis"], rod["size"]["length"]) == ("capsule", "x", 2.5)
    assert rod["at"] == [-1.25, 0, 0]
    assert ball["size"] == {"radius": 0.1}


@pytest.mark.parametrize(
    ("mass", "theta", "reason"),
    [(0.0, 0.1, "undetermined"), (1.0, np.inf, "not finite"), (1, 0, "")],
)
def test_a_singular_state_is_refused_with_the_reason(
    mass: float, theta: float, reason: str, engine: Engine
) -> None:
    """As the compiled model does; a page stops there and says so."""
    machine = engine.machine(model("pendulum"))
    p = model("pendulum").parameter_vector(m=mass).tolist()
    body = f"""try {{ {machine}.step([a ?? Infinity, 0], [0], 0.1, b); return "" }}
        catch (error) {{ return error.message }}"""
    found = engine.run(body, theta if np.isfinite(theta) else None, p)
    assert reason in found
    assert bool(found) == bool(reason)


def test_feedback_is_held_over_a_step(engine: Engine) -> None:
    """The law's inputs at the beginning, given to the machine without it, lead to the same."""
    made, machine = model("cart_pole"), engine.machine(model("cart_pole"))
    x = [0.1, 0.05, 0.2, -0.1]
    closed, opened = engine.run(
        f"""const m = {machine}, u = m.acting(a, b, m.defaults);
        return [m.step(a, b, 0.02), m.plant.step(a, u, 0.02)].map(x => Array.from(x))""",
        x,
        [0.5],
    )
    assert closed == opened
    assert engine.run(f"return [{machine}.inputNames, {machine}.plant.inputNames]") == [
        ["speed"],
        ["push"],
    ]
    acting = engine.run(f"return Array.from({machine}.acting(a, b, {machine}.defaults))", x, [0.5])
    np.testing.assert_allclose(acting, made.plant_inputs(x, [0.5]), rtol=1e-12)


def test_a_torque_without_a_place_has_no_arrow(engine: Engine) -> None:
    """Whoever holds a turn holds it with a torque."""
    a, b = angle("a"), angle("b")
    first = Body("first", rot_z(a), mass=1.0, inertia=1.0)
    second = Body("second", move(1.0) @ rot_z(b), mass=1.0, inertia=1.0)
    motor = Torque("motor", on=first, about=rot_z(a).z, limit=1.0)
    gear = zero(rate(b) - 2 * rate(a), "gear")
    made = System("gear", bodies=[first, second], constraints=[gear], inputs=[motor]).model()
    (arrow,) = engine.run(f"return {engine.machine(made)}.arrows(a, b)", [0, 0, 1], [0.5])
    assert arrow["at"] is None  # it holds two bodies against each other
    assert arrow["value"] == pytest.approx(made.constraint_forces([0, 0, 1], [0.5])[0])
