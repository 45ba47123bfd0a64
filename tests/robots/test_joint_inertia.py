"""Inertia that is only rounding is none: joints that it alone resists are refused, others move."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from kinolab.errors import InputError
from kinolab.robots import read_mjcf, read_urdf
from tests.support import needs

pytestmark = needs("yourdfpy")

NOISE = 1e-20  # [kg m^2]


def link(name: str, mass: float, inertia: float, at: str = "0 0 0", box: str = "") -> str:
    """A link with three equal moments about its centre of mass."""
    moments = " ".join(f'{m}="{inertia if m[1] == m[2] else 0}"' for m in
                       ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))  # fmt: skip
    shape = f'<collision><geometry><box size="{box}"/></geometry></collision>' if box else ""
    mass_of = f'<inertial><origin xyz="{at}"/><mass value="{mass}"/><inertia {moments}/></inertial>'
    return f'<link name="{name}">{mass_of}{shape}</link>'


def joint(parent: str, child: str, axis: str, further: str = "", **changes: str) -> str:
    told = {"type": "continuous", "at": "0 0 0", "effort": "10", **changes}
    return (
        f'<joint name="to_{child}" type="{told["type"]}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{told["at"]}"/><axis xyz="{axis}"/>'
        f'<limit lower="-1" upper="1" effort="{told["effort"]}" velocity="2"/>{further}</joint>'
    )


def robot(folder: Path, *parts: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    return path


IDLE = {
    "a point on the axis": (link("a", 0.7, NOISE), joint("base", "a", "0 0 1")),
    "with a shape": (link("a", 0.7, NOISE, box="0.05 0.05 0.2"), joint("base", "a", "0 0 1")),
    "along the axis": (link("a", 2.0, NOISE, at="0 0 0.3"), joint("base", "a", "0 0 1")),
    "an axis in five digits": (
        link("a", 2.0, 0.0, at="0 0.3 0"),
        joint("base", "a", "0 1 0.000002"),
    ),
    "exactly nothing": (link("a", 2.0, 0.0, at="0 0 0.3"), joint("base", "a", "0 0 1")),
    "a gram": (link("a", 1e-3, 1e-23, box="0.01 0.01 0.01"), joint("base", "a", "0 0 1")),
    "what is fixed to it": (
        link("a", 0.5, NOISE, box="0.1 0.1 0.1"),
        joint("base", "a", "0 0 1"),
        link("b", 0.5, NOISE, box="0.1 0.1 0.1"),
        joint("a", "b", "0 0 1", type="fixed", at="0 0 0.4"),
    ),
}


@pytest.mark.parametrize("name", IDLE)
def test_a_joint_that_only_rounding_resists_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"joint 'to_a': it turns a .* that has no inertia"):
        read_urdf(robot(tmp_path, *IDLE[name]))


# Machines with an inertia about the joint's axis that is known by hand, in [kg m^2].
RESISTED = {
    "a small wheel": (2.5e-13, (link("a", 1e-6, 2.5e-13), joint("base", "a", "0 0 1"))),
    "a frame on a small wheel": (  # of no mass, as robots have them at their tools
        2.5e-13,
        (
            link("a", 1e-6, 2.5e-13),
            joint("base", "a", "0 0 1"),
            '<link name="tool"/>',
            joint("a", "tool", "0 0 1", type="fixed", at="0 0.005 0"),
        ),
    ),
    "a mote": (1e-15, (link("a", 1e-9, 1e-15), joint("base", "a", "0 0 1"))),
    "a wire of a metre": (
        1e-3 * 1e-4**2 / 2,  # [kg m^2] of 0.2 mm
        (link("a", 1e-3, 1e-3 * 1e-4**2 / 2, box="0.0002 0.0002 1"), joint("base", "a", "0 0 1")),
    ),
    "an arm of a point": (
        0.5 * 0.2**2,
        (link("a", 0.5, -5e-20, at="0 0 -0.2"), joint("base", "a", "0 1 0")),
    ),
    "noise beside a shape": (
        0.3 * 0.1**2,
        (link("a", 0.3, -3e-19, at="0.1 0 0", box="0.2 0.1 0.1"), joint("base", "a", "0 0 1")),
    ),
    "a follower": (  # which turns twice as far
        4 * 0.5 * 0.2**2,
        (
            link("a", 0.1, NOISE),
            joint("base", "a", "0 0 1"),
            link("b", 0.5, 0.0, at="0.2 0 0"),
            joint("base", "b", "0 0 1", '<mimic joint="to_a" multiplier="2"/>', effort="0"),
        ),
    ),
}


@pytest.mark.parametrize("name", RESISTED)
def test_a_torque_of_one_accelerates_by_the_inverse_of_the_inertia(
    name: str, tmp_path: Path
) -> None:
    inertia, parts = RESISTED[name]
    model = read_urdf(robot(tmp_path, *parts)).model()
    pushed, free = (float(model.f([0.0, 0.0], [u])[1]) for u in (1.0, 0.0))
    assert pushed - free == pytest.approx(1 / inertia, rel=1e-9)


def test_a_mass_that_is_on_the_axis_in_one_position_only_resists(tmp_path: Path) -> None:
    """The elbow, bent by q, holds 0.5 kg at 0.3 sin(q) metres from the waist's axis."""
    parts = (
        link("a", 0.1, NOISE),
        joint("base", "a", "0 0 1"),
        link("b", 0.5, 0.0, at="0 0 0.3"),
        joint("a", "b", "0 1 0"),
    )
    model = read_urdf(robot(tmp_path, *parts)).model()
    x = [0.0] * model.nx
    x[list(model.state_names).index("to_b")] = bent = 0.7
    turn = list(model.state_names).index("to_a_dot")
    inertia = 0.5 * (0.3 * math.sin(bent)) ** 2
    pushed, free = (float(model.f(x, [u, 0.0])[turn]) for u in (1.0, 0.0))
    assert pushed - free == pytest.approx(1 / inertia, rel=1e-9)


def test_an_inertia_that_is_negative_beyond_rounding_is_refused(tmp_path: Path) -> None:
    parts = (link("a", 0.5, -1e-6, at="0 0 -0.2"), joint("base", "a", "0 1 0"))
    with pytest.raises(InputError, match="negative principal moment, -1e-06"):
        read_urdf(robot(tmp_path, *parts))


@needs("mujoco")
def test_a_rotor_resists_a_joint_of_mjcf(tmp_path: Path) -> None:
    """A ball of 2 kg and 1 cm turns about its own axis: 2/5 m r^2 and the rotor's 0.01 kg m^2."""
    path = tmp_path / "model.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="j" axis="0 0 1" armature="0.01"/>'
        '<geom type="sphere" size=".01" mass="2"/></body></worldbody>'
        '<actuator><motor joint="j" ctrlrange="-1 1"/></actuator></mujoco>'
    )
    model = read_mjcf(path).model()
    inertia = 0.4 * 2 * 0.01**2 + 0.01
    assert model.f([0.0, 0.0], [1.0])[1] == pytest.approx(1 / inertia, rel=1e-9)


@pytest.mark.parametrize("kind", ["fixed", "floating"])
def test_what_follows_a_joint_that_has_no_position_is_told_so(kind: str, tmp_path: Path) -> None:
    held = f'<joint name="held" type="{kind}"><parent link="base"/><child link="a"/></joint>'
    parts = (
        link("a", 0.5, 1e-3, at="0 0 -0.2"),
        held,
        link("b", 0.5, 1e-3, at="0 0 -0.2"),
        joint("a", "b", "0 0 1", '<mimic joint="held" offset="0.3"/>', effort="0"),
    )
    with pytest.raises(InputError, match=r"held, which it follows, does not turn or slide.*0\.3"):
        read_urdf(robot(tmp_path, *parts))


def test_many_wheels_of_unit_inertia_are_derived_and_turn_as_they_are_driven(
    tmp_path: Path,
) -> None:
    """Their accelerations are the torques themselves, over 1 kg m^2 (as in r2d2.urdf)."""
    wheels = "abcdefghi"
    parts = [part for w in wheels for part in (link(w, 1.0, 1.0), joint("base", w, "0 0 1"))]
    model = read_urdf(robot(tmp_path, *parts), shapes=False).model()
    n = len(wheels)
    A, B = model.jacobian(np.zeros(2 * n), np.zeros(n))
    zero, one = np.zeros((n, n)), np.eye(n)
    np.testing.assert_allclose(A, np.block([[zero, one], [zero, zero]]), atol=1e-15)
    np.testing.assert_allclose(B, np.vstack([zero, one]), atol=1e-15)
