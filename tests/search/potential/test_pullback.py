"""Forces on points become generalised forces by virtual work, and those become inputs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear, minimize

from kinolab import systems
from kinolab.dynamics import Body, Model, Rate, Sphere, System, length, move
from kinolab.errors import NoDynamicsError
from kinolab.numerics.bounded_lsq import bounded_least_squares
from kinolab.search.potential.field import PointForce
from kinolab.search.potential.pullback import (
    InputProjection,
    generalised_force,
    independent_entries,
    point_jacobians,
    reduced_mass,
)

Array = NDArray[np.float64]

MACHINES = ("diff_drive", "car", "crane", "submarine", "snakeboard", "rolling_disk", "two_cranes")


def some_state(model: Model, seed: int) -> Array:
    """A state in the middle of its limits, moving, with attitudes turned."""
    generator = np.random.default_rng(seed)
    x = generator.uniform(-0.3, 0.3, model.nx)
    lower, upper = model.state_bounds.T
    x = np.clip(x, np.maximum(lower, -1e3), np.minimum(upper, 1e3))
    for first in model.attitudes.values():
        q = generator.normal(size=4)
        x[first : first + 4] = q / np.linalg.norm(q)
    return model.project(x)


def some_points(model: Model, x: Array, seed: int) -> list[tuple[int, Array]]:
    generator = np.random.default_rng(seed)
    poses = model.frames(x).reshape(-1, 3, 4)
    return [(k, pose[:, 3] + generator.uniform(-1, 1, 3)) for k, pose in enumerate(poses)]


def carried(poses: Array, here: Array, body: int, at: Array) -> Array:
    """Where a point of a body is at other poses, which is there now."""
    now, then = here.reshape(-1, 3, 4)[body], poses.reshape(-1, 3, 4)[body]
    return np.asarray(then[:, :3] @ now[:, :3].T @ (at - now[:, 3]) + then[:, 3])


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("seed", range(3))
def test_points_move_as_the_equations_of_motion_move_them(name: str, seed: int) -> None:
    """A second route: the machine's own integrator over a short time, forwards and back.

    The step's error and that of central differences are both of order h^2, 1e-8 of the motion.
    """
    model = systems.get(name).model()
    x, h = some_state(model, seed), 1e-4
    v = x[independent_entries(model)]
    points = some_points(model, x, seed)
    jacobians = point_jacobians(model, x, points)
    rest = np.clip(np.zeros(model.nu), *model.control_bounds.T)
    here, after, before = (model.frames(model.step(x, rest, dt)) for dt in (0.0, h, -h))
    for (body, at), jacobian in zip(points, jacobians, strict=True):
        moved = carried(after, here, body, at) - carried(before, here, body, at)
        assert jacobian @ v == pytest.approx(moved / (2 * h), abs=2e-6)  # [m/s]


@pytest.mark.parametrize("name", MACHINES)
def test_the_power_of_a_generalised_force_is_that_of_the_forces(name: str) -> None:
    """Virtual work: tau . v = sum f . p_dot, whatever the velocities."""
    model = systems.get(name).model()
    generator, x, h = np.random.default_rng(0), some_state(model, 1), 1e-5
    points = some_points(model, x, 2)
    forces = [PointForce(body, at, generator.normal(size=3)) for body, at in points]
    tau = generalised_force(point_jacobians(model, x, points), forces)
    entries = independent_entries(model)
    for _ in range(5):
        moving = x.copy()
        moving[entries] = v = generator.normal(size=len(tau))
        q_dot = model.f(moving)[: model.nq] if model.nu else np.zeros(model.nq)
        ahead, behind = x.copy(), x.copy()
        ahead[: model.nq] += h * q_dot
        behind[: model.nq] -= h * q_dot
        here, there, back = (model.frames(state) for state in (x, ahead, behind))
        power = 0.0
        for force in forces:
            moved = carried(there, here, force.body, force.at)
            moved = moved - carried(back, here, force.body, force.at)
            power += float(force.force @ moved) / (2 * h)
        assert tau @ v == pytest.approx(power, rel=1e-7, abs=1e-7)  # [W]


def test_a_boats_point_moves_by_its_velocity_and_its_spin() -> None:
    """Closed form: p_dot = v + R (w x r), w in the body's axes."""
    model = systems.get("submarine").model()
    x = some_state(model, 4)
    pose = model.frames(x)[0].reshape(3, 4)
    r = np.array([0.7, -0.2, 0.3])
    (jacobian,) = point_jacobians(model, x, [(0, pose[:, :3] @ r + pose[:, 3])])
    hat = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    assert jacobian[:, :3] == pytest.approx(np.eye(3), abs=1e-9)
    assert jacobian[:, 3:] == pytest.approx(-pose[:, :3] @ hat, abs=1e-9)


def test_a_crane_s_load_has_the_jacobian_of_a_second_engine() -> None:
    """Pinocchio: two rails, two hinges (the first turns the other way), one rope downwards."""
    pin: Any = pytest.importorskip("pinocchio", reason="the second engine is not installed")
    tree = pin.Model()
    joints = (pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRY(), pin.JointModelRX())
    last = 0
    for k, joint in enumerate((*joints, pin.JointModelPZ())):
        last = tree.addJoint(last, joint, pin.SE3.Identity(), str(k))
    model = systems.get("crane").model()
    x = model.rest()
    named = {"x": 2.0, "y": 3.0, "l": 5.0, "theta_x": 0.2, "theta_y": -0.1}
    for name, value in named.items():
        x[model.state_names.index(name)] = value
    signs = {"x": 1.0, "y": 1.0, "theta_x": -1.0, "theta_y": 1.0, "l": -1.0}
    q = np.array([signs[name] * named[name] for name in signs])
    data = tree.createData()
    jacobian = pin.computeJointJacobians(tree, data, q)
    jacobian = pin.getJointJacobian(tree, data, last, pin.LOCAL_WORLD_ALIGNED)[:3]
    load = model.frames(x)[0].reshape(3, 4)[:, 3]
    (ours,) = point_jacobians(model, x, [(0, load)])
    velocities = list(model.state_names[model.nq :])
    for k, (name, sign) in enumerate(signs.items()):
        column = ours[:, velocities.index(f"{name}_dot")]
        assert column == pytest.approx(sign * jacobian[:, k], abs=1e-9)


@pytest.mark.parametrize("name", MACHINES)
def test_the_reduced_mass_holds_the_kinetic_energy(name: str) -> None:
    model = systems.get(name).model()
    x = some_state(model, 5)
    v = x[independent_entries(model)]
    kinetic = model.energy(x)[0]
    assert v @ reduced_mass(model, x) @ v / 2 == pytest.approx(kinetic, rel=1e-9)


# --- least squares within bounds ---


@pytest.mark.parametrize("seed", range(20))
def test_bounded_least_squares_are_those_of_scipy(seed: int) -> None:
    generator = np.random.default_rng(seed)
    A, b = generator.normal(size=(6, 3)), 3 * generator.normal(size=6)
    lower, upper = -generator.uniform(0, 1, 3), generator.uniform(0.1, 1, 3)
    ours = bounded_least_squares(A, b, lower, upper)
    best = lsq_linear(A, b, (lower, upper), method="bvls").x
    assert ours == pytest.approx(best, abs=1e-6)


def test_of_equally_good_answers_the_smallest_is_taken() -> None:
    found = bounded_least_squares(np.array([[1.0, 1.0]]), np.ones(1), -np.ones(2), np.ones(2))
    assert found == pytest.approx([0.5, 0.5], abs=1e-6)
    nothing = bounded_least_squares(np.zeros((2, 2)), np.ones(2), -np.ones(2), np.ones(2))
    assert nothing == pytest.approx([0.0, 0.0], abs=1e-12)


# --- through the inputs ---


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("seed", range(3))
def test_no_inputs_come_nearer_to_what_is_wanted(name: str, seed: int) -> None:
    """Against a general minimiser; nearness is measured by the mass matrix."""
    model = systems.get(name).model()
    generator, x = np.random.default_rng(seed), some_state(model, seed)
    entries, mass = independent_entries(model), reduced_mass(model, some_state(model, seed))
    wanted = generator.normal(size=entries.stop - entries.start)
    found = InputProjection(model, 1.0, 1.0).nearest_inputs(x, mass, wanted)
    lower, upper = model.control_bounds.T
    assert (found >= lower - 1e-9 * (upper - lower)).all()
    assert (found <= upper + 1e-9 * (upper - lower)).all()

    def miss(shares: Array) -> float:
        away = model.f(x, lower + shares * (upper - lower))[entries] - wanted
        return float(away @ mass @ away)

    share = (found - lower) / (upper - lower)
    for start in (np.full(model.nu, 0.5), share):
        best = minimize(miss, start, bounds=[(0.0, 1.0)] * model.nu, method="L-BFGS-B")
        assert miss(share) <= best.fun * (1 + 1e-6) + 1e-9


def crane_pulled(body: int, force: tuple[float, float, float]) -> tuple[Model, Array, Array]:
    """Inputs of a crane at rest that something pulls at, and the accelerations they give."""
    model = systems.get("crane").model()
    x = model.rest()
    x[model.state_names.index("l")] = 5.0
    at = model.frames(x)[body].reshape(3, 4)[:, 3]
    u = InputProjection(model, 1.0, 0.0).inputs(x, [PointForce(body, at, np.array(force))], 1)
    return model, u, model.f(x, u)


def test_a_crane_lifts_where_its_load_is_pulled_up() -> None:
    model, u, dx = crane_pulled(0, (0.0, 0.0, 1.0))
    assert dx[model.state_names.index("l_dot")] == pytest.approx(-1.0, abs=1e-6)  # [m/s^2]
    assert u[:2] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_crane_s_sway_is_not_forced_directly() -> None:
    """A pull across the rope asks the load alone to move; no input does that without the trolley.

    In the metric of the masses the trolley is asked to stay, and stays: this is why inputs are
    judged some time ahead as well.
    """
    model, u, dx = crane_pulled(0, (1.0, 0.0, 0.0))
    assert u[0] == pytest.approx(0.0, abs=1e-3)  # [N] of 3000 N
    assert dx[model.state_names.index("theta_x_dot")] == pytest.approx(0.0, abs=1e-6)


def test_a_crane_s_trolley_follows_a_pull_at_itself() -> None:
    model, u, dx = crane_pulled(2, (1.0, 0.0, 0.0))
    assert u[0] > 1000.0  # [N]
    assert dx[model.state_names.index("x_dot")] > 0.2  # [m/s^2]


def test_a_robot_pulled_forwards_drives_and_pulled_sideways_at_its_nose_turns() -> None:
    model = systems.get("diff_drive").model()
    x = model.rest()
    nose = model.frames(x)[0].reshape(3, 4)[:, 3] + [0.2, 0.0, 0.0]
    project = InputProjection(model, 0.5, 0.0)
    left, right = project.inputs(x, [PointForce(0, nose, np.array([1.0, 0.0, 0.0]))], 1)
    assert left == pytest.approx(right, rel=1e-9)
    assert left > 0
    left, right = project.inputs(x, [PointForce(0, nose, np.array([0.0, 1.0, 0.0]))], 1)
    assert left == pytest.approx(-right, rel=1e-6)
    assert right > 0


def test_damping_alone_brakes() -> None:
    model = systems.get("diff_drive").model()
    x = model.rest()
    x[independent_entries(model)] = 3.0
    u = InputProjection(model, 1.0, 1.0).inputs(x, [], 0)
    assert model.f(x, u)[independent_entries(model)] == pytest.approx([-3.0, -3.0], rel=1e-6)


def test_a_kinematic_machine_has_no_masses_to_pull_back_through() -> None:
    x = length("x", -5, 5)
    slider = Body("slider", move(x, 0, 0), shape=Sphere(0.1))
    machine = System("slider", bodies=[slider], inputs=[Rate("drive", on=x, limit=1.0)])
    model = machine.model()
    force = PointForce(0, np.zeros(3), np.ones(3))
    with pytest.raises(NoDynamicsError, match="slider is kinematic"):
        InputProjection(model, 1.0, 1.0).inputs(model.rest(), [force], 1)
