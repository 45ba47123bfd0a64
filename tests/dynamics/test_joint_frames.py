"""Frames of joints: where a chain of motions has come with each coordinate."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Body, System, angle, length, move, parameter, rot_y, rot_z
from kinolab.dynamics.facts.machine_facts import facts_of


def test_a_coin_has_a_frame_that_walks_and_one_that_turns_with_its_heading() -> None:
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi")
    coin = Body("coin", move(x, y, 0.25) @ rot_z(psi) @ rot_y(phi), mass=1.0, inertia=0.1)
    joints = facts_of(System("coin", bodies=[coin])).joints
    assert joints.names == ("x, y", "psi")  # the last one is the coin's own
    walked, turned = joints.at(np.array([[1.0, 2.0, np.pi / 2, 0.3]]), ("x", "y", "psi", "phi"))[0]
    np.testing.assert_allclose(
        walked.reshape(3, 4), np.eye(3, 4) + np.outer([1, 2, 0.25], [0, 0, 0, 1])
    )
    quarter = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 0.25]]
    np.testing.assert_allclose(turned.reshape(3, 4), quarter, atol=1e-15)


def test_joints_of_an_arm_are_where_its_links_meet_whatever_its_parameters() -> None:
    reach, a, b = parameter("l", 1.0, "m"), angle("a"), angle("b")
    upper = rot_z(a)
    links = [
        Body("upper", upper @ move(reach / 2), mass=1.0, inertia=0.1),
        Body("fore", upper @ move(reach) @ rot_z(b) @ move(reach / 2), mass=1.0, inertia=0.1),
    ]
    arm = System("arm", bodies=links).with_parameters(l=3.0)
    joints, q = facts_of(arm).joints, np.array([[0.4, 0.7], [1.0, -2.0]])
    assert joints.names == ("a", "b")
    shoulder, elbow = joints.at(q, ("a", "b"))[..., 3::4].swapaxes(0, 1)
    np.testing.assert_allclose(shoulder, 0.0)
    np.testing.assert_allclose(
        elbow[:, :2], 3.0 * np.stack([np.cos(q[:, 0]), np.sin(q[:, 0])], axis=1)
    )


def test_a_body_at_its_joint_is_named_once() -> None:
    theta = angle("theta")
    assert (
        facts_of(System("rod", bodies=[Body("rod", rot_y(theta), inertia=1.0)])).joints.names == ()
    )
