"""Compiled functions: by address as from Python, from many threads, and how they fail."""

import ctypes
import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import kinolab.systems
from kinolab.dynamics import Body, Model, System, angle, length, move, parameter, rot_z
from kinolab.dynamics.codegen import derived_code
from kinolab.dynamics.codegen import llvm_jit as compilation_module
from kinolab.dynamics.codegen.compiled_functions import NOT_FINITE, SINGULAR
from kinolab.errors import InputError, SingularError, UnknownNameError
from tests.dynamics.machines import compiled, compiled_random

MODELS: dict[str, Any] = {
    "rolling_disk": lambda: kinolab.systems.get("rolling_disk").model(),
    "pendulum": lambda: kinolab.systems.get("pendulum").model(),
    "cart": lambda: compiled("cart"),
    "road_train": lambda: compiled("road_train"),
    **{str(seed): lambda seed=seed: compiled_random(seed) for seed in range(4)},
}
POINTER, LONG, DOUBLE = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double


def call(model: Model, name: str, arrays: list[Any], size: int) -> tuple[int, Any]:
    """Call a compiled function by its address; the output is surrounded by sentinels."""
    out = np.full(size + 2, 12345.0)
    kept = [np.ascontiguousarray(a, dtype=float) for a in arrays]
    types = [POINTER] * (len(kept) + 1)
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *types, LONG)(model.address(name))
    status = function(*(a.ctypes.data for a in kept), out[1:].ctypes.data, 0)
    assert out[0] == out[-1] == 12345.0, "it wrote beyond its output"
    return status, out[1:-1]


def draw(model: Model, seed: int = 0, count: int = 1) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.8, 0.8, (count, model.nx)), rng.uniform(-1, 1, (count, model.nu))


@pytest.mark.parametrize("name", MODELS)
def test_functions_by_address_equal_the_methods(name: str) -> None:
    model = MODELS[name]()
    (x,), (u,) = draw(model)
    p = model.parameter_vector()
    nb = len(model.system.bodies)
    pairs = {
        "f": ([x, u, p], model.f(x, u)),
        "velocity": ([x, u, p], model.velocity(x, u)),
        "point_speed": ([x, u, p], model.point_speed(x, u)),
        "constraint_residual": ([x, u, p], model.constraint_residual(x, u)),
        "frames": ([x, p], model.frames(x)),
        "energy": ([x, u, p], np.array(model.energy(x, u))),
        "mass_matrix": ([x, p], model.mass_matrix(x)),
    }
    assert model.frames(x).shape == (nb, 12)
    for function, (arrays, expected) in pairs.items():
        status, out = call(model, function, arrays, expected.size)
        assert status == 0, function
        # Contraction of a * b + c may differ where f is inlined: two units in the last place.
        np.testing.assert_allclose(out, expected.ravel(), rtol=1e-13, atol=1e-13, err_msg=function)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("method", ["rk4", "euler"])
@pytest.mark.parametrize("substeps", [1, 3])
def test_a_step_by_address_is_the_textbooks(name: str, method: str, substeps: int) -> None:
    model = MODELS[name]()
    (x,), (u,) = draw(model, 1)
    u = np.ascontiguousarray(u)
    whole, h, expected = 0.01, 0.01 / substeps, x
    for _ in range(substeps):
        at, k1 = expected, model.f(expected, u)
        expected = at + h * k1
        if method == "rk4":
            k2 = model.f(at + h / 2 * k1, u)
            k3 = model.f(at + h / 2 * k2, u)
            expected = at + h / 6 * (k1 + 2 * k2 + 2 * k3 + model.f(at + h * k3, u))
    reached = model.step(x, u, whole, method=method, substeps=substeps)
    np.testing.assert_allclose(reached, expected, rtol=1e-13, atol=1e-14)
    out, p = np.empty(model.nx), model.parameter_vector()
    types = (POINTER, POINTER, POINTER, DOUBLE, POINTER, LONG, LONG)
    step = ctypes.CFUNCTYPE(ctypes.c_int32, *types)(model.address(f"step_{method}"))
    arguments = (x.ctypes.data, u.ctypes.data, p.ctypes.data, whole, out.ctypes.data, substeps, 0)
    assert step(*arguments) == 0
    assert out.tobytes() == reached.tobytes()


def test_rk4_is_of_fourth_order_and_euler_of_first() -> None:
    model = kinolab.systems.get("pendulum").model()
    x0, u = np.array([1.0, 0.5]), [0.3]

    def end(method: str, steps: int) -> Any:
        x = x0
        for _ in range(steps):
            x = model.step(x, u, 1.0 / steps, method=method)
        return x

    exact = end("rk4", 4000)
    for method, order in (("rk4", 4), ("euler", 1)):
        errors = [np.abs(end(method, n) - exact).max() for n in (40, 80)]
        assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("name", MODELS)
def test_a_batch_is_its_rows(name: str) -> None:
    model = MODELS[name]()
    x, u = draw(model, 2, 5)
    for method in ("f", "velocity", "point_speed", "constraint_residual"):
        together = getattr(model, method)(x, u)
        rows = np.array([getattr(model, method)(a, b) for a, b in zip(x, u, strict=True)])
        np.testing.assert_array_equal(together, rows)
    for method in ("frames", "mass_matrix"):
        together = getattr(model, method)(x)
        np.testing.assert_array_equal(together, [getattr(model, method)(a) for a in x])
    np.testing.assert_array_equal(model.step(x, u, 0.1)[3], model.step(x[3], u[3], 0.1))
    kinetic, potential = model.energy(x)
    assert (kinetic[2], potential[2]) == model.energy(x[2])
    np.testing.assert_array_equal(model.f(x, u[0]), model.f(x, np.tile(u[0], (5, 1))))
    np.testing.assert_array_equal(model.f(x), model.f(x, np.zeros((5, model.nu))))
    np.testing.assert_array_equal(model.configuration(x), x[:, : model.nq])
    assert model.f(np.zeros((0, model.nx))).shape == (0, model.nx)


def test_inputs_are_not_changed_and_may_be_strided() -> None:
    model = kinolab.systems.get("rolling_disk").model()
    x, u = draw(model, 3, 8)
    before = x.copy()
    np.testing.assert_array_equal(model.f(x[::2], u[::2]), model.f(x, u)[::2])
    turned = np.asfortranarray(x)
    np.testing.assert_array_equal(model.f(turned, u), model.f(x, u))
    np.testing.assert_array_equal(x, before)


def test_eight_threads_get_what_one_gets() -> None:
    model = compiled_random(0)
    x, u = draw(model, 4, 4000)
    alone = (model.f(x, u), model.frames(x[:200]), model.step(x[:200], u[:200], 0.01))

    def work(_: int) -> list[bytes]:
        made = (model.f(x, u), model.frames(x[:200]), model.step(x[:200], u[:200], 0.01))
        return [part.tobytes() for part in made]

    with ThreadPoolExecutor(8) as pool:
        for made in pool.map(work, range(16)):
            assert made == [part.tobytes() for part in alone]


# Parameters


def test_parameters_at_run_time_are_those_of_a_machine_made_with_them() -> None:
    model = kinolab.systems.get("rolling_disk").model()
    other = kinolab.systems.get("rolling_disk", R=0.4, m=2.3).model()
    x, u = draw(model, 5, 6)
    for name in ("f", "velocity", "point_speed"):
        made = getattr(model, name)(x, u, R=0.4, m=2.3)
        np.testing.assert_array_equal(made, getattr(other, name)(x, u))
        assert not np.array_equal(made, getattr(model, name)(x, u))
    np.testing.assert_array_equal(model.step(x, u, 0.1, R=0.4, m=2.3), other.step(x, u, 0.1))
    np.testing.assert_array_equal(model.energy(x, R=0.4, m=2.3), other.energy(x))
    np.testing.assert_array_equal(model.frames(x, R=0.4), other.frames(x))
    np.testing.assert_array_equal(model.mass_matrix(x, R=0.4, m=2.3), other.mass_matrix(x))


def test_another_parameter_value_compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    model = kinolab.systems.get("pendulum").model()

    def refuse(*_: Any) -> Any:
        raise AssertionError("it was compiled again")

    monkeypatch.setattr(compilation_module, "compile_ir", refuse)
    monkeypatch.setattr(derived_code, "compiled", refuse)
    monkeypatch.setattr(derived_code, "derive", refuse)
    # theta_ddot = -g/l sin(theta) + u / (m l^2)
    value = model.f([0.5, 0.0], [2.0], l=2.0, m=3.0)[1]
    assert value == pytest.approx(-9.81 / 2 * math.sin(0.5) + 2.0 / (3 * 4), rel=1e-14)
    assert model.f([0.5, 0.0])[1] == pytest.approx(-9.81 * math.sin(0.5), rel=1e-14)


def test_an_unknown_parameter_is_an_error_that_knows_the_others() -> None:
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(UnknownNameError) as caught:
        model.f([0, 0], mass=3.0)
    assert str(caught.value) == "no parameter is called 'mass'. Known: g, l, m."
    assert caught.value.known == ("g", "l", "m")


def test_a_model_is_released_only_when_nothing_calls_it() -> None:
    kept = kinolab.systems.get("pendulum").model().f
    assert kept([0.5, 0.0])[1] == pytest.approx(-9.81 * math.sin(0.5))


# Failure


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_has_a_status(value: float) -> None:
    model = kinolab.systems.get("pendulum").model()
    p = model.parameter_vector()
    assert call(model, "f", [[value, 0.0], [0.0], p], 2)[0] == NOT_FINITE
    assert call(model, "f", [[0.0, value], [0.0], p], 2)[0] == NOT_FINITE
    assert call(model, "f", [[0.0, 0.0], [value], p], 2)[0] == NOT_FINITE
    assert call(model, "frames", [[value, 0.0], p], 12)[0] == NOT_FINITE
    assert call(model, "energy", [[0.0, value], [0.0], p], 2)[0] == NOT_FINITE


def test_an_overflow_has_a_status() -> None:
    model = kinolab.systems.get("pendulum").model()
    p = model.parameter_vector()
    assert call(model, "energy", [[0.0, 1e200], [0.0], p], 2)[0] == NOT_FINITE


def test_a_singular_mass_has_a_status() -> None:
    model = kinolab.systems.get("pendulum").model()
    for values in ({"m": 0.0}, {"m": -1.0}, {"l": 0.0}):
        p = model.parameter_vector(**values)
        assert call(model, "f", [[0.1, 0.0], [0.0], p], 2)[0] == SINGULAR


def test_the_method_raises_where_the_function_fails() -> None:
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(SingularError, match=r"^pendulum: the equations of motion cannot be "):
        model.f([0.1, 0.0], m=0.0)
    rows = np.array([[0.1, 0.0], [0.2, 0.0], [math.nan, 0.0]])
    with pytest.raises(SingularError, match="theta=nan"):
        model.f(rows)
    with pytest.raises(SingularError):
        model.step(rows, [0.0], 0.1)


def test_a_state_that_is_not_finite_is_named_as_the_cause() -> None:
    """No chart is left here: the pendulum has none."""
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(SingularError) as caught:
        model.f([math.nan, 0.0])
    assert str(caught.value) == (
        "pendulum: the equations of motion cannot be solved at theta=nan, theta_dot=0: "
        "the result is not finite."
    )


def test_a_singular_step_is_named_as_such() -> None:
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(SingularError, match="a velocity or mass is undetermined"):
        model.step([0.1, 0.0], [0.0], 0.1, m=0.0)


def test_singular_points_of_the_coordinates_are_refused() -> None:
    """Gimbal lock: three turns about axes that coincide two by two."""
    from tests.dynamics.derivation.test_derivation import free_body

    model = free_body().model()
    x = np.zeros(12)
    x[model.coordinate_names.index("pitch")] = math.pi / 2
    with pytest.raises(SingularError):
        model.f(x)


def test_dependent_velocities_outside_the_chart_are_not_silently_infinite() -> None:
    x, y = length("x"), length("y")
    from kinolab.dynamics import rate, zero

    bead = Body("bead", move(x, y), mass=1)
    slope = zero(x * rate(y) - rate(x), "slope")
    model = System("s", bodies=[bead], constraints=[slope], velocities=[x]).model()
    assert model.velocity([2.0, 0.0, 1.0]) == pytest.approx([1.0, 0.5])
    with pytest.raises(SingularError):
        model.velocity([0.0, 0.0, 1.0])


# Wrong questions


def test_inputs_that_leave_the_chart_are_refused_too() -> None:
    """Wheels across the car stop it: no yaw rate follows from its speed."""
    model = kinolab.systems.get("car1_v0").model()
    with pytest.raises(SingularError, match="outside the chart of the independent velocities"):
        model.f(np.zeros(4), [1.0, math.pi / 2])


@pytest.mark.parametrize("x", [[0.0], [0.0, 0.0, 0.0], [[[0.0, 0.0]]], 0.0, []])
def test_a_state_of_the_wrong_shape_is_an_error(x: Any) -> None:
    model = kinolab.systems.get("pendulum").model()
    shape = np.ascontiguousarray(x).shape
    with pytest.raises(InputError) as caught:
        model.f(x)
    assert str(caught.value) == f"x has shape {shape}; it must be (2,) or (N, 2)."


def test_inputs_of_the_wrong_length_are_an_error() -> None:
    model = kinolab.systems.get("rolling_disk").model()
    with pytest.raises(InputError) as caught:
        model.f(np.zeros(6), [1.0, 2.0, 3.0])
    assert str(caught.value) == (
        "system 'rolling_disk': u has shape (3,); the last axis must be 2. Inputs: drive, steer."
    )


@pytest.mark.parametrize(("x", "u"), [((2, 6), (3, 2)), ((6,), (3, 2)), ((2, 6), (1, 2, 2))])
def test_inputs_for_another_number_of_states_are_an_error(x: Any, u: Any) -> None:
    model = kinolab.systems.get("rolling_disk").model()
    with pytest.raises(InputError, match="u has shape"):
        model.f(np.zeros(x), np.zeros(u))


def test_an_unknown_method_is_an_error() -> None:
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(UnknownNameError) as caught:
        model.step([0, 0], [0], 0.1, method="rk5")
    expected = (
        "no integration method is called 'rk5'. Did you mean 'rk4'? Known: euler, rk4, rosenbrock."
    )
    assert str(caught.value) == expected


def test_names_and_bounds() -> None:
    model = kinolab.systems.get("rolling_disk").model()
    assert model.state_names == ("x", "y", "psi", "phi", "psi_dot", "phi_dot")
    assert model.rate_names == ("x_dot", "y_dot", "psi_dot", "phi_dot")
    assert model.control_names == ("drive", "steer")
    np.testing.assert_array_equal(model.control_bounds, [[-1, 1], [-0.5, 0.5]])
    np.testing.assert_array_equal(model.state_bounds[4:], [[-4, 4], [-12, 12]])
    assert (model.nx, model.nu, model.nq) == (6, 2, 4)


def test_a_parameter_may_have_any_name_of_python() -> None:
    """The author's names are free; ``x``, ``u`` and ``dt`` are arguments of the methods."""
    x, th = parameter("x", 2.0, "m"), angle("th")
    body = Body("b", rot_z(th) @ move(x), mass=1.0)
    system = System("s", bodies=[body])
    assert system.model().mass_matrix([0.0])[0, 0] == pytest.approx(4.0)
    assert system.with_parameters(x=3.0).model().mass_matrix([0.0])[0, 0] == pytest.approx(9.0)
