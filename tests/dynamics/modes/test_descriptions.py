"""What machines with modes are made of: files, facts and mistakes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.dynamics import Mode, Model, System, Transition, rate
from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from tests.switching_machines import ball, compass_walker, hopper, walled_pendulum


@pytest.mark.parametrize("make", [ball, walled_pendulum, hopper, compass_walker])
def test_a_file_gives_the_same_machine(make: Callable[[], System]) -> None:
    machine = make()
    text = machine_to_json(machine)
    again = machine_from_json(text)
    assert machine_to_json(again) == text
    x = np.array([*np.linspace(0.1, 0.4, machine.model().nx - 1), 0.0])
    assert Model(again).f(x).tobytes() == machine.model().f(x).tobytes()


def test_a_state_says_in_which_mode_it_is() -> None:
    model = hopper().model()
    assert model.state_names == ("z", "s", "z_dot", "s_dot", "mode")
    assert model.machine.modes == ("stance", "flight")
    assert [model.mode(np.array([1.0, 0, 0, 0, k])) for k in (0.0, 1.0)] == ["stance", "flight"]
    assert model.state_bounds[-1].tolist() == [0.0, 1.0]
    assert model.residual_names == ("foot on the ground", "foot on the ground")


def test_each_mode_has_its_own_equations() -> None:
    """With the leg relaxed the foot of 1 kg stands under 8 kg, or all fall with g."""
    model = hopper().model()
    assert model.f([0.8, 0.0, 0.0, 0.0, 0.0])[2:] == pytest.approx([-9.81, -9.81, 0.0])
    assert model.constraint_forces([0.8, 0.0, 0.0, 0.0, 0.0])[0] == pytest.approx(9.81)
    assert model.f([0.9, 0.0, 0.0, 0.0, 1.0])[2:] == pytest.approx([-9.81, 0.0, 0.0])
    assert model.constraint_forces([0.9, 0.0, 0.0, 0.0, 1.0]).tolist() == [0.0]
    assert model.constraint_residual([0.9, 0.0, 0.5, 0.0, 1.0]).tolist() == [0.0, 0.0]


def test_all_mistakes_of_modes_are_told() -> None:
    z = ball().coordinates[0]
    wrong = [
        Transition("up", "flight", "moon", until=z),
        Transition("down", "sea", "flight", until=z, reset={rate(z): 0, ball().coordinates[0]: 1}),
        Transition("off", "flight", "flight", until=z, restitution=1.5),
        Transition("off", "flight", "flight", until=z),
    ]
    with pytest.raises(InputError) as raised:
        ball().changed(transitions=wrong, modes=[Mode("flight"), Mode("flight")])
    told = str(raised.value)
    for part in ("'moon'", "'sea'", "restitution is 1.5", "mode 'flight'", "transition 'off'"):
        assert part in told, part


def test_what_no_mode_can_do_is_refused_in_words() -> None:
    with pytest.raises(InputError, match="no modes"):
        ball().changed(modes=[], states=[])
    with pytest.raises(InputError, match="different in each of its modes"):
        derive(hopper())
