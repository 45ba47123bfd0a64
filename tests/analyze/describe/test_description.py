"""``plan describe``: what is said of machines whose nature is known."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from kinolab import cli, systems
from kinolab.analyze.describe.at_rest import held_state
from kinolab.analyze.describe.data import description_to_json
from kinolab.analyze.describe.description import Description, describe
from kinolab.analyze.describe.description_text import described_as_text
from kinolab.analyze.describe.topology import mechanisms, space_of
from kinolab.dynamics import (
    Body,
    Force,
    SmallTime,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rot_z,
    toward,
)
from kinolab.dynamics.model.units import in_digits
from tests import registered
from tests.machines import MACHINES

ALL = (*registered.NAMES, *MACHINES)


def machine(name: str) -> System:
    return MACHINES[name]() if name in MACHINES else registered.MAKERS[name]()


@cache
def described(name: str) -> Description:
    return describe(machine(name))


@pytest.mark.parametrize(
    ("name", "space", "dimension"),
    [
        ("pendulum", "S^1", 1),
        ("rolling_disk", "R^2 x S^1 x S^1", 4),
        ("crane", "R^5", 5),
        ("submarine", "R^3 x SO(3)", 6),
        ("satellite", "S^1 x S^1 x S^1 x SO(3)", 6),
        pytest.param("marionette", "R^9 x T^16 x SO(3)", 28, marks=pytest.mark.long),
        ("driven_crane", "R^3", 3),  # an angle with limits is an interval
    ],
)
def test_configuration_spaces_are_products(name: str, space: str, dimension: int) -> None:
    assert space_of(machine(name)) == space
    assert described(name).dimension == dimension


def test_bodies_are_told_with_their_masses_and_the_boxes_around_their_shapes() -> None:
    """By hand: the hull of 0.4 x 0.26 m from the castor, 97.5 mm below the axle, to 0.2 m above."""
    robot, left, right = described("diff_drive").bodies
    assert (robot.name, robot.mass) == ("robot", 9.0)
    assert robot.extent == pytest.approx((0.40, 0.26, 0.2975))
    assert left.mass == right.mass == 0.0  # the robot's mass counts the wheels
    assert left.extent == pytest.approx((0.195, 0.04, 0.195))
    text = described_as_text(described("diff_drive")).splitlines()
    assert "  bodies: 3" in text
    words = {" ".join(line.split()) for line in text}
    assert "left wheel 0.005 kg m^2 0.195 x 0.04 x 0.195 m" in words
    data = description_to_json(described("diff_drive"))["bodies"]
    assert [body["name"] for body in data] == ["robot", "left wheel", "right wheel"]


def test_numbers_have_units_and_no_exponents() -> None:
    """What only turns has its moment of inertia, and a heavy body no power of ten."""
    q, M, J = angle("q"), parameter("M", 3000.0, "kg"), parameter("J", 0.02, "kg m^2")
    hull, rotor = Body("hull", move(length("x")), mass=M), Body("rotor", rot_z(q), inertia=J)
    found = describe(System("s", bodies=[hull, rotor]))
    text = described_as_text(found).splitlines()
    assert "    hull   3000 kg      no shape" in text
    assert "    rotor  0.02 kg m^2  no shape" in text
    assert text[text.index("  parameters: 2") + 1 :][:2] == ["    J  0.02 kg m^2", "    M  3000 kg"]
    assert description_to_json(found)["parameter_units"] == {"J": "kg m^2", "M": "kg"}
    shown = [in_digits(value) for value in (3e3, 1234567.0, 0.0012345, 2e12, -0.5)]
    assert shown == ["3000", "1230000", "0.00123", "2e+12", "-0.5"]


def test_a_body_without_a_shape_has_no_extent() -> None:
    q = angle("q")
    bob = Body("bob", rot_z(q) @ move(1.0), mass=2.5)
    found = describe(System("s", bodies=[bob]))
    assert [(body.mass, body.extent) for body in found.bodies] == [(2.5, None)]
    assert "    bob  2.5 kg  no shape" in described_as_text(found)


def test_two_cranes_are_two_mechanisms_and_others_are_one() -> None:
    assert mechanisms(systems.get("two_cranes")) == [
        ("x_a", "l_a", "sway_a"),
        ("x_b", "l_b", "sway_b"),
    ]
    others = [name for name in ALL if name not in ("two_cranes", "satellite")]
    assert all(len(mechanisms(machine(name))) == 1 for name in others)
    assert len(mechanisms(machine("satellite"))) == 1  # its hull joins the wheels


MODES = {  # internal or potential, many inputs, much freedom, feedback, several, transitions
    "pendulum": "100000",
    "rolling_disk": "000000",  # what the others go beyond
    "falling_disk": "101100",
    "crane": "111000",
    "two_cranes": "111010",
    "unicycle": "101100",
    "motorcycle": "101100",
    "unicycle1_v0": "000000",
    "unicycle2_v0": "000000",
    "diff_drive": "000000",
    "snakeboard": "101000",  # it rolls on; no input pushes that
    "slip_steered": "101000",  # it skids; no input pushes that
    "helicopter": "111000",
    "satellite": "111000",
    "submarine": "111000",
    "sprung_cart": "100000",
    "four_bar": "100000",
}


@pytest.mark.parametrize("name", MODES)
def test_machines_show_the_modes_of_generalisation_that_they_have(name: str) -> None:
    assert "".join(str(int(mode.shown)) for mode in described(name).generalisations) == MODES[name]


def test_the_six_modes_are_those_of_the_source() -> None:
    assert [mode.name for mode in described("pendulum").generalisations] == [
        "internal dynamics or potential energy",
        "more than two inputs",
        "more degrees of freedom",
        "feedback",
        "several mechanisms",
        "state transitions",
    ]


@pytest.mark.parametrize(
    ("name", "dry", "places"),
    [
        *(("satellite", {}, 0), ("satellite", {"tau_c": 0.01}, 3), ("sprung_cart", {}, 1)),
        *(("slip_steered", {}, 4), ("slip_steered", {"mu": 0.0}, 0)),
    ],
)
def test_dry_friction_is_told_where_it_has_a_strength(
    name: str, dry: dict[str, float], places: int
) -> None:
    """It is a smooth law, so that no state sticks; without a strength there is nothing to tell."""
    found = describe(systems.get(name, **dry)) if dry else described(name)
    why = found.generalisations[5].why
    assert not found.generalisations[5].shown
    assert ("dry friction" in why) == (places > 0)
    assert ("regularised" in why) == (places > 0)
    if places:
        assert f"in {places} place" in why
    assert "sticks and slips" not in described_as_text(found)


STATES = {  # dimension of the state space as textbooks have it, and what is stored
    "helicopter": (12, 13, ()),  # SE(3) and its velocities
    "quad3d_v0": (12, 13, ()),
    "submarine": (12, 13, ()),
    "satellite": (12, 13, ()),  # SO(3) and three wheels
    "satellite_two_wheels": (10, 11, ()),
    "whipple": (10, 11, ()),  # 7 configurations and 3 velocities (Meijaard et al. 2007)
    "car1_v0": (4, 4, ()),
    "unicycle2_v0": (5, 5, ("v", "w")),
    "four_bar": (2, 4, ()),  # one crank angle and its rate
    "pendulum": (2, 2, ()),
    "crane": (10, 10, ()),
}


@pytest.mark.parametrize("name", STATES)
def test_the_state_space_has_the_dimension_of_the_textbook(name: str) -> None:
    dimension, stored, further = STATES[name]
    found = described(name)
    data = description_to_json(found)
    assert (data["states"], data["stored_numbers"]) == (dimension, stored)
    assert tuple(data["further_states"]) == further
    text = described_as_text(found)
    assert f"states: {dimension}\n" in text
    assert (f"stored as {stored} numbers" in text) == (stored > dimension)
    assert all(state in text for state in further)


def test_inputs_that_count_as_states_in_brackets_are_named_as_such() -> None:
    text = " ".join(described_as_text(described("helicopter")).split())
    assert "of the 16 dimensions of the state space and the inputs, which count as states" in text


ONE_AND_BOTH = ("unicycle1_v1", "unicycle1_v0")


def test_a_machine_that_only_goes_forward_is_not_said_to_follow_any_path() -> None:
    """Its speed is at least 0.25 m/s: it can neither go back nor slow down."""
    forward, both = (" ".join(described_as_text(described(n)).split()) for n in ONE_AND_BOTH)
    assert "follow any path" not in forward
    assert "v one way only (0.25 to 0.5" in forward
    assert "follow any path made of such motions if it moves slowly enough" in both


def test_what_is_left_of_a_configuration_space_by_holonomic_constraints_is_said() -> None:
    """A bicycle's front wheel touches the ground: seven of its eight coordinates are free."""
    assert "dimension 8 (7 under its holonomic constraints)" in described_as_text(
        described("whipple")
    )


def test_where_constraints_depend_on_inputs_nothing_is_claimed_of_them() -> None:
    found = described("car1_v0")
    assert {constraint.kind for constraint in found.constraints} == {"depends on inputs"}
    assert found.freedom == 1
    assert any("depend on inputs" in sentence for sentence in found.left_out)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("rolling_disk", ["nonholonomic", "nonholonomic"]),
        ("four_bar", ["holonomic", "holonomic"]),
        ("four_bar_by_multipliers", ["holonomic", "holonomic", "repeats others"]),
    ],
)
def test_constraints_are_called_what_they_are(name: str, kinds: list[str]) -> None:
    assert [constraint.kind for constraint in described(name).constraints] == kinds


@pytest.mark.parametrize(
    ("name", "outcomes"),
    [
        ("pendulum", [SmallTime.LINEAR]),
        ("crane", [SmallTime.LINEAR]),
        ("quad3d_v0", [SmallTime.LINEAR]),
        ("rolling_disk", [SmallTime.BRACKETS]),
        ("diff_drive", [SmallTime.BRACKETS]),  # on what its wheels leave
        ("unicycle1_v0", [SmallTime.DRIFTLESS]),
        ("unicycle1_v1", []),  # it cannot stop
        ("satellite", [SmallTime.UNREACHABLE]),
        ("submarine", [SmallTime.KINKED] * 2),  # its drag is |v| v; level, and not
        ("snakeboard", [SmallTime.UNFINISHED, SmallTime.BRACKETS]),  # steered straight, and not
    ],
)
def test_controllability_at_rest_is_what_is_known(name: str, outcomes: list[SmallTime]) -> None:
    found = [rest.small_time.outcome for rest in described(name).rests if rest.small_time]
    assert found == outcomes


LONGEST = "marionette"  # a third of all


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name == LONGEST else name
        for name in (*registered.NAMES, "four_bar_by_multipliers")
    ],
)
def test_every_machine_is_described_in_words_and_in_data(name: str) -> None:
    """What is said of rest is so: the machine stays there."""
    found = described(name)
    text, data = described_as_text(found), json.loads(json.dumps(description_to_json(found)))
    assert data["name"] == found.name
    assert len(data["modes"]) == 6
    assert all(entry["name"] in text for entry in (*data["inputs"], *data["constraints"]))
    assert max(map(len, text.splitlines())) <= 100
    model = machine(name).model().plant
    for rest in data["rests"]:
        x = [rest["state"][state] for state in model.state_names]
        u = [rest["held"][control] for control in model.control_names]
        assert np.abs(model.f(x, u) / model.state_scales).max() < 1e-8


def test_an_equilibrium_that_the_inputs_cannot_hold_is_none() -> None:
    """A pendulum held level takes 9.81 N m; its motor has 5. Slightly aside it can be held."""
    model = systems.get("pendulum").model()
    assert held_state(model, [np.array([np.pi / 2, 0.0])]) is None
    found = held_state(model, [np.array([np.pi / 2, 0.0]), np.array([0.3, 0.0])])
    assert found is not None
    (theta, _), (torque,) = found
    assert torque == pytest.approx(9.81 * np.sin(theta), abs=1e-8)


def test_a_machine_without_inputs_is_described_too() -> None:
    rod = Body("rod", rot_z(angle("th")) @ move(1.0), mass=1.0)
    found = describe(System("free", bodies=[rod], gravity=toward("+x")))
    assert (found.accessible.rank, found.pushes, found.freedom) == (0, 0, 1)
    assert found.rests[0].linear.directions == ("th", "th_dot")
    assert "inputs: none" in described_as_text(found)


# --- the command ---


def test_the_command_prints_the_description(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["describe", "rolling_disk"]) == 0
    assert capsys.readouterr().out == described_as_text(described("rolling_disk")) + "\n"


def test_the_command_prints_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["describe", "rolling_disk_maze", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["configuration_space"] == "R^2 x S^1 x S^1"
    assert data["growth_vector"] == [2, 3, 4]


def test_the_command_describes_a_machine_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the file prints is no result."""
    monkeypatch.chdir(tmp_path)
    assert cli.run(["new", "hopper"]) == 0
    file = tmp_path / "hopper.py"
    file.write_text("print('made')\n" + file.read_text())
    capsys.readouterr()
    assert cli.run(["describe", "hopper.py", "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["name"] == "hopper"
    assert "made" in err


def test_an_unknown_machine_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["describe", "rolling_disc"]) == 2
    assert "Did you mean 'rolling_disk'?" in capsys.readouterr().err


def test_a_controller_that_must_not_rest_says_nothing_of_where_its_machine_can() -> None:
    """The coin stands on its rim without torque; its controller wants at least 1.2 m/s."""
    disk = systems.get("falling_disk")
    found = described("falling_disk"), describe(disk.with_feedback(None))
    controlled, alone = map(description_to_json, found)
    modes, modes_alone = controlled.pop("modes"), alone.pop("modes")
    assert controlled == alone
    differing = [a["name"] for a, b in zip(modes, modes_alone, strict=True) if a != b]
    assert differing == ["feedback"]
    assert not any("no state was found" in text for text in controlled["left_out"])


def puck(low: float, high: float) -> System:
    """A puck without friction, with a thruster ahead and a motor that turns it."""
    x, y, t = length("x"), length("y"), angle("t")
    frame = move(x, y) @ rot_z(t)
    hull = Body("hull", frame, mass=2.0, inertia=0.3)
    ahead = Force("ahead", on=hull, along=frame.x, limit=(low, high))
    return System(
        "puck", bodies=[hull], inputs=[ahead, Torque("yaw", on=hull, about=frame.z, limit=1.0)]
    )


@pytest.mark.parametrize(
    ("limits", "controllable"), [((0.0, 1.0), False), ((-1.0, 1.0), True), ((-2.0, 0.0), False)]
)
def test_a_push_that_nothing_brakes_follows_no_field_from_rest_to_rest(
    limits: tuple[float, float], controllable: bool
) -> None:
    """The speed ahead only grows, or only falls: no motion along x ends at rest."""
    found = describe(puck(*limits))
    assert found.decoupling is not None
    assert found.decoupling.controllable is controllable
    assert ("ahead" in " ".join(found.decoupling.one_way)) is not controllable


def arm(*driven: int) -> System:
    """Two links without gravity, whose centres lie off their joints."""
    q1, q2 = angle("q1"), angle("q2")
    first = rot_z(q1)
    second = first @ move(0.9) @ rot_z(q2)
    upper = Body("upper", first @ move(0.45), mass=1.3, inertia=0.12)
    fore = Body("fore", second @ move(0.5), mass=1.6, inertia=0.14)
    motors = [
        Torque("tau1", on=upper, about=first.z, limit=3.0),
        Torque("tau2", on=fore, about=second.z, limit=3.0, reacts_on=upper),
    ]
    return System("arm", bodies=[upper, fore], inputs=[motors[k] for k in driven])


def test_what_holds_of_the_stretched_arm_alone_is_not_said_of_the_arm() -> None:
    """Driven at its shoulder: M depends on cos q2, whose slope is 0 where the arm is stretched.

    The bad bracket [tau1, [drift, tau1]] is the gradient of M's entries along tau1: zero there, and
    one-sided elsewhere (Sussmann 1987).
    """
    stretched, bent = describe(arm(0)).rests
    assert stretched.small_time is not None
    assert stretched.small_time.controllable is True
    assert bent.state["q2"] % np.pi > 0.1
    assert bent.small_time is not None
    assert bent.small_time.outcome is SmallTime.ONE_WAY
    assert len(describe(arm(0, 1)).rests) == 1  # a motor per joint: the same at every rest
