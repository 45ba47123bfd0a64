"""Several machines as one: each moves as it does alone."""

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import Model, System
from kinolab.dynamics.analysis.lqr_design import with_law
from kinolab.dynamics.facts.machine_facts import member_of, members
from kinolab.dynamics.together import part_of, together
from kinolab.errors import InputError

PAIRS = [
    ("rolling_disk", "rolling_disk"),
    ("car", "diff_drive"),
    ("falling_disk", "diff_drive"),  # one with a law of feedback, one without
    ("satellite", "unicycle1_v0"),  # an attitude; velocities as inputs
    ("crane", "crane"),
]


def random_state(model: Model, generator: np.random.Generator) -> np.ndarray:
    return model.space.unit(0.2 * generator.normal(size=(1, model.nx)))[0]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_each_moves_as_alone(first: str, second: str) -> None:
    generator = np.random.default_rng(0)
    alone = {"a": with_law(systems.get(first)), "b": with_law(systems.get(second))}
    whole = together(alone)
    model, parts = Model(whole), {name: Model(part_of(whole, name)) for name in alone}
    assert members(model.machine.name) == ("a", "b")
    for _ in range(5):
        x, u, expected = np.zeros(model.nx), np.zeros(model.nu), np.zeros(model.nx)
        for name, system in alone.items():
            own = Model(system)
            state, inputs = random_state(own, generator), 0.2 * generator.normal(size=own.nu)
            rows = [model.state_names.index(f"{name}_{n}") for n in own.state_names]
            chosen = [
                k for k, n in enumerate(model.control_names) if member_of(n, ["a", "b"]) == name
            ]
            x[rows], u[chosen] = state, inputs
            expected[rows] = own.f(state, inputs)
            part = parts[name]
            order = [f"{name}_{n}" for n in own.state_names]
            again = part.f(state[[order.index(n) for n in part.state_names]], inputs)
            np.testing.assert_allclose(
                again, expected[[model.state_names.index(n) for n in part.state_names]], atol=1e-10
            )
        np.testing.assert_allclose(model.f(x, u), expected, atol=1e-10)


def test_bodies_of_different_machines_may_not_touch() -> None:
    disk = systems.get("rolling_disk")
    whole = together({"left": disk, "right": disk})
    assert ("left_coin", "right_coin") in whole.collisions


def test_gravity_must_be_one() -> None:
    falling, sliding = systems.get("acrobot_v0"), systems.get("diff_drive")
    with pytest.raises(InputError, match="machine 'b': it has no gravity, which another one has"):
        together({"a": falling, "b": sliding})


def test_machines_with_modes_are_refused() -> None:
    with pytest.raises(InputError, match="machine 'a': it has modes"):
        together({"a": systems.get("biped"), "b": systems.get("diff_drive")})


def test_names_of_machines_of_which_one_begins_like_another() -> None:
    disk = systems.get("rolling_disk")
    whole = together({"a": disk, "a_b": disk})
    assert [body.name for body in part_of(whole, "a").bodies] == ["a_coin"]
    assert [body.name for body in part_of(whole, "a_b").bodies] == ["a_b_coin"]
    assert isinstance(System.of(whole), System)


def test_what_is_not_read_of_a_robot_s_file_is_still_said() -> None:
    disk = systems.get("rolling_disk")
    robot = disk.changed(notes=[("", "friction is not read."), ("joint_2", "it follows joint_1.")])
    whole = together({"a": disk, "b": robot})
    assert whole.notes == (("", "friction is not read."), ("b_joint_2", "it follows joint_1."))
