"""Emitted machines in another engine: what a page simulates is what kinolab compiled.

The two share expressions and nothing else: LLVM's machine code may fuse products into sums, and its
sines are another library's. So they differ by rounding, and by what a motion makes of it.
"""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.errors import SingularError
from tests.dynamics.javascript.machines import MAKERS, inputs, model, states
from tests.javascript_engine import Engine

Array = NDArray[np.float64]

SAME = 1e-12  # share of the largest entry
STEP = 0.02  # [s]
FAR = 1e3  # in any entry of a state: what falls over without a controller has left its laboratory

# A bicycle stands by itself only while it rides; at rest it falls, and leaves its chart.
BEGINNING = {"whipple": {"phi": 0.1, "delta": -0.05, "theta_R_dot": 17.0}}
GENTLE = {"whipple": 0.02}  # share of the inputs' limits

BRIEF = {"marionette": 1e-3}  # [s]: strings that begin stretched by metres
every_machine = pytest.mark.parametrize("name", list(MAKERS))


def apart(found: ArrayLike, expected: ArrayLike) -> float:
    """The largest difference as a share of the row's largest entry, or of one unit."""
    one, other = np.atleast_2d(found), np.atleast_2d(expected)
    if not other.size:
        return 0.0 if one.size == other.size else np.inf
    return float((np.abs(one - other) / np.abs(other).max(axis=-1, keepdims=True, initial=1)).max())


def listed(values: Array) -> Any:
    return values.tolist()


@every_machine
def test_the_rate_of_change_is_the_compiled_one(name: str, engine: Engine) -> None:
    """Relative to the largest rate; a state that has none has none in either."""
    made, x, machine = model(name), states(name), engine.machine(model(name))
    u = inputs(name, len(x))
    body = f"""return a.map((x, i) => {{
        try {{ return Array.from({machine}.f(x, b[i])) }} catch (error) {{ return null }}
    }})"""
    for found, at, under in zip(engine.run(body, listed(x), listed(u)), x, u, strict=True):
        try:
            expected = made.f(at, under)
        except SingularError:
            assert found is None
        else:
            np.testing.assert_allclose(found, expected, rtol=0, atol=SAME * np.abs(expected).max())


@every_machine
def test_poses_cables_and_margins_are_the_compiled_ones(name: str, engine: Engine) -> None:
    made, x, machine = model(name), states(name), engine.machine(model(name))
    u = inputs(name, len(x))
    body = f"""return a.map((x, i) => [
        {machine}.frames(x), {machine}.cableEnds(x), {machine}.margins(x, b[i]),
    ].map(values => Array.from(values)))"""
    poses, cables, margins = zip(*engine.run(body, listed(x), listed(u)), strict=True)
    assert apart(poses, made.frames(x).reshape(len(x), -1)) < SAME
    assert apart(cables, made.cables(x).reshape(len(x), -1)) < SAME
    assert apart(margins, made.requirements(x, u)) < SAME


@pytest.mark.parametrize("name", [name for name in MAKERS if not is_kinematic(MAKERS[name]())])
def test_energies_and_forces_of_constraints_are_the_compiled_ones(
    name: str, engine: Engine
) -> None:
    """Forces of redundant constraints are a choice that a factor of 1e8 leaves: fewer digits."""
    made, x, machine = model(name), states(name), engine.machine(model(name))
    u = inputs(name, len(x))
    body = f"""return a.map((x, i) => {{
        const {{ kinetic, potential }} = {machine}.energy(x, b[i]);
        return [[kinetic, potential], Array.from({machine}.constraintForces(x, b[i]))];
    }})"""
    energies, forces = zip(*engine.run(body, listed(x), listed(u)), strict=True)
    assert apart(energies, np.transpose(made.energy(x, u))) < SAME
    assert apart(forces, made.constraint_forces(x, u)) < (1e-6 if made.redundant else SAME)


@pytest.mark.parametrize("method", ["rk4", "euler", "rosenbrock"])
@every_machine
def test_a_step_is_the_compiled_one(name: str, method: str, engine: Engine) -> None:
    """A hundredth of a second from random states, in two substeps, the last bits aside."""
    h = BRIEF.get(name, 0.01)
    made, x, machine = model(name), states(name), engine.machine(model(name))
    u = inputs(name, len(x), 0.2)
    body = f"""return a.map((x, i) => {{
        try {{ return Array.from({machine}.step(x, b[i], {h}, {machine}.defaults, c, 2)) }}
        catch (error) {{ return null }}
    }})"""
    found = engine.run(body, listed(x), listed(u), method)
    for after, at, under in zip(found, x, u, strict=True):
        try:
            expected = made.step(at, under, h, method=method, substeps=2)
        except SingularError:
            assert after is None
        else:
            assert apart(after, expected) < 1e-9  # wild rates amplify rounding within the step


@every_machine
def test_five_seconds_under_varying_inputs_lead_to_the_same_states(
    name: str, engine: Engine
) -> None:
    """Both go on from their own states; what falls over is followed until it has fallen."""
    made, machine = model(name), engine.machine(model(name))
    held = np.repeat(inputs(name, 50, GENTLE.get(name, 0.05)), 5, axis=0)
    x = made.rest()
    for entry, value in BEGINNING.get(name, {}).items():
        x[made.state_names.index(entry)] = value
    if name in ("four_bar_by_multipliers", "rope_pendulum"):
        x = states(name)[0]
    motion = [x]
    for u in held:
        motion.append(made.step(motion[-1], u, STEP))
        if np.abs(motion[-1]).max() > FAR:
            break
    expected = np.array(motion)
    assert len(expected) > 1 / STEP
    body = f"""let x = a; const seen = [a];
        for (const u of b) {{ x = {machine}.step(x, u, c); seen.push(Array.from(x)); }}
        return seen"""
    found = engine.run(body, listed(x), listed(held[: len(expected) - 1]), STEP)
    assert apart(found, expected) < 1e-6


@every_machine
def test_other_parameters_need_no_other_code(name: str, engine: Engine) -> None:
    """As sliders change them: every one by a few percent, both engines told so."""
    made, machine = model(name), engine.machine(model(name))
    x, u = states(name)[:1], inputs(name, 1)
    values = {n: v * 1.03 for n, v in made.system.parameter_values.items()}
    p = made.parameter_vector(**values)
    found = engine.run(f"return Array.from({machine}.f(a, b, c))", *map(listed, (x[0], u[0], p)))
    assert apart(found, made.f(x[0], u[0], **values)) < SAME
    names = engine.run(f"return {machine}.parameters.map(entry => entry.name)")
    assert names == list(made.parameter_names)
