"""Tubes against exact reachable sets, and against motions of other machines by SciPy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Force, Sphere, System, Viscous, length, move, parameter, rate
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.systems.pendulum import pendulum
from kinolab.verification.tube.proof import Prover
from kinolab.verification.tube.uncertainty import Uncertainty
from tests.closed_loops import executed, outside

STEPS, STEP = 40, 0.05
Array = np.ndarray[Any, np.dtype[np.float64]]


def cart(limit: float = 100.0) -> System:
    """A mass that a force pushes against drag; linear in the state, and in the force."""
    m, c, x = (
        parameter("m", 2.0, "kg"),
        parameter("c", 0.5, "N s/m"),
        length("x", -5.0, 5.0, speed=2.0),
    )
    frame = move(x)
    body = Body("cart", frame, mass=m, shape=Sphere(0.1))
    push = Force("push", on=body, along=frame.x, limit=limit)
    return System("cart", bodies=[body], inputs=[push], efforts=[Viscous(rate(x), c)])


def prover(system: System, inputs: Array, goal: dict[str, Any], **further: Any) -> Prover:
    """Return a prover of the motion under given inputs."""
    table = {"system": system, "goal": goal, "integration": {"step": STEP}, **further}
    problem: PlanningTask = kinolab.load(table)
    t = STEP * np.arange(len(inputs) + 1.0)
    return Prover(problem, resimulate(problem, t, inputs.reshape(-1, 1)))


@pytest.fixture(scope="module")
def linear() -> Prover:
    push = np.where(np.arange(STEPS) < STEPS // 2, 1.0, -1.0)
    return prover(cart(), push, {"x": 0.5, "tolerance": 1.0})


@pytest.fixture(scope="module")
def swinging() -> Prover:
    """A pendulum that its motor swings with all it has, so that feedback is cut all the time."""
    push = np.where(np.arange(STEPS) % 20 < 10, 5.0, -4.0)
    return prover(pendulum(), push, {"theta": 0.5, "tolerance": 3.0})


@pytest.mark.parametrize(("noise", "disturbance"), [(0.0, 0.01), (0.01, 0.0), (0.005, 0.005)])
def test_a_linear_machine_stays_in_its_exact_reachable_set(
    linear: Prover, noise: float, disturbance: float
) -> None:
    """Of x+ = A x + B (-K (x + e) + d) the set's box is a sum of magnitudes, worked out here."""
    uncertainty = Uncertainty({}, noise, disturbance)
    tube = linear.prove(uncertainty).tube
    decay = np.exp(-0.25 * STEP)
    A = np.array([[1.0, (1.0 - decay) / 0.25], [0.0, decay]])
    B = np.array([[(STEP - (1.0 - decay) / 0.25) / 0.5], [(1.0 - decay) / 0.5]])
    e, d = uncertainty.measurement_radii(linear.problem), uncertainty.input_radii(linear.problem)
    generators = np.zeros((2, 0))
    for k in range(STEPS):
        K = linear.tracker.gains[k]
        new = np.hstack([B @ K * e, B * d])
        generators = np.hstack([(A - B @ K) @ generators, new])
        exact, found = np.abs(generators).sum(axis=1), tube.sets[k + 1].radius
        assert (found >= exact * (1.0 - 1e-12)).all()
        assert (found <= 1.1 * exact).all()  # the bound that a linear machine must keep


@pytest.mark.parametrize("name", ["linear", "swinging"])
def test_machines_within_the_uncertainty_stay_in_the_tube(
    name: str, request: pytest.FixtureRequest
) -> None:
    """Corners and the inside of all intervals; the integrator shares nothing with the tube."""
    made: Prover = request.getfixturevalue(name)
    shares = {"c": 0.05} if name == "linear" else {}
    uncertainty = Uncertainty({"m": 0.01, **shares}, 1e-4, 1e-3)
    tube = made.prove(uncertainty).tube
    assert tube.complete
    for seed in range(12):
        states = executed(made, uncertainty, seed, corner=seed % 2 == 0)
        assert (outside(tube, states) <= 1e-9 * made.problem.scales).all()


def test_a_tube_is_at_most_three_times_as_wide_as_what_is_seen(swinging: Prover) -> None:
    """At its widest, beside the hull of corners: what intervals cost."""
    uncertainty = Uncertainty({"m": 0.01})
    tube = swinging.prove(uncertainty).tube
    runs = np.array([executed(swinging, uncertainty, k, corner=True) for k in range(6)])
    seen = np.ptp(runs, axis=0).max(axis=0)
    assert ((tube.bounds.high - tube.bounds.low).max(axis=0) <= 3.0 * seen).all()


def test_nothing_uncertain_is_a_tube_of_nothing_but_rounding(linear: Prover) -> None:
    proof = linear.prove(Uncertainty())
    assert proof.proved
    sizes = np.array([one.radius for one in proof.tube.sets])
    assert (sizes <= 1e-6 * linear.problem.scales).all()  # as exact as nominal steps are enclosed


def test_an_obstacle_in_the_tube_is_named_and_beyond_it_is_not() -> None:
    push = np.where(np.arange(STEPS) < STEPS // 2, 1.0, -1.0)

    def hazard_at(x: float) -> Any:
        box = {"box": [0.1, 1.0, 1.0], "position": [x, 0.0, 0.0], "name": "post"}
        goal = {"x": 0.5, "tolerance": 1.0}
        made = prover(cart(), push, goal, world={"obstacle": [box]})
        return made.prove(Uncertainty({"m": 0.05}))

    reach = float(resimulated_reach(push))
    near, far = hazard_at(reach + 0.1505), hazard_at(reach + 0.25)
    assert not near.proved
    assert "cart could touch post" in near.hazards[0].what
    assert far.proved
    assert far.spare < 0.1


def resimulated_reach(push: Array) -> float:
    made = prover(cart(), push, {"x": 0.5, "tolerance": 1.0})
    return float(made.about.nominal.x[:, 0].max())


def test_what_is_too_uncertain_ends_with_a_time_and_a_share(swinging: Prover) -> None:
    asked = Uncertainty({"m": 0.9})
    proof = swinging.prove(asked)
    assert not proof.proved
    assert proof.first is not None
    share, best = swinging.largest(asked)
    assert 0.0 < share < 1.0
    assert best is not None
    assert best.proved


def test_a_larger_uncertainty_has_a_larger_tube(linear: Prover) -> None:
    small, large = (linear.prove(Uncertainty({"m": share})).tube for share in (0.01, 0.02))
    for one, other in zip(small.sets, large.sets, strict=True):
        assert (one.radius <= other.radius * (1.0 + 1e-9)).all()


@pytest.mark.parametrize(
    ("uncertainty", "words"),
    [
        (Uncertainty({"m": 1.2}), "it could be -0.4"),
        (Uncertainty({"q": 0.1}), "no parameter is called 'q'"),
        (Uncertainty({}, noise=-1.0), "no share"),
    ],
)
def test_senseless_uncertainty_is_refused(
    linear: Prover, uncertainty: Uncertainty, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        linear.prove(uncertainty)


def test_sizes_of_shapes_are_taken_as_they_are(swinging: Prover) -> None:
    with pytest.raises(InputError, match="size of a shape depends on it"):
        swinging.prove(Uncertainty({"l": 0.01}))


def test_machines_that_switch_are_sent_to_plan_execute() -> None:
    problem = kinolab.load("biped_walk")
    motion = resimulate(problem, np.array([0.0, 1e-3]), np.zeros((1, problem.model.nu)))
    with pytest.raises(InputError, match="plan execute"):
        Prover(problem, motion)


def test_noise_is_worse_than_none(linear: Prover) -> None:
    quiet, loud = (linear.prove(Uncertainty({"m": 0.01}, noise)) for noise in (0.0, 1e-3))
    assert loud.tube.sets[-1].radius[0] > quiet.tube.sets[-1].radius[0]
    assert replace(loud.uncertainty, noise=0.0) == quiet.uncertainty
