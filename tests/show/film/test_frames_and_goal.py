"""Axes in films, paths in the air, and how much of the goal's outline is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Cylinder,
    Load,
    Sphere,
    System,
    angle,
    length,
    move,
    rate,
    rot_y,
    rot_z,
)
from kinolab.show.film.film import staged
from kinolab.show.film.staging.drawn_axes import X, Y, Z
from kinolab.show.film.staging.script_writing import write_script
from kinolab.show.scene.picture import Ghost, GoalMarker
from kinolab.show.scene.problem_picture import picture


def hand_and_block() -> System:
    """Two bodies that nothing joins."""
    x, z, bx = length("x", -2, 2), length("z", 0, 2), length("bx", -2, 2)
    hand = Body("hand", move(x, 0, z), mass=1.0, shape=Box(0.2, 0.2, 0.1))
    block = Body("block", move(bx, 0, 0.05), mass=1.0, shape=Box(0.1, 0.1, 0.1))
    return System("hand_and_block", bodies=[hand, block])


def wheel() -> System:
    """A wheel whose turn one does not see."""
    x, phi = length("x", -2, 2), angle("phi")
    frame = move(x, 0, 0.2) @ rot_y(phi)
    return System(
        "wheel",
        bodies=[
            Body(
                "wheel",
                frame,
                inertia=1.0,
                mass=1.0,
                shape=Cylinder(0.2, 0.1, axis="y"),
                color=(0.5, 0.5, 0.5),
            )
        ],
    )


def shown(machine: System, goal: dict[str, float], *states: dict[str, float], **more: Any) -> Any:
    push = Control("push", limit=1.0)  # who plans needs one
    pushed = [*machine.efforts, Load(push.symbol, rate(machine.coordinates[0]))]
    machine = machine.changed(inputs=[push], efforts=pushed)
    problem = kinolab.load({"system": machine, "goal": goal, "bounds": _speeds(machine), **more})
    names = list(problem.model.state_names)
    x = np.zeros((len(states), len(names)))
    for row, state in zip(x, states, strict=True):
        for name, value in state.items():
            row[names.index(name)] = value
    return problem, picture(problem, x), x


def _speeds(machine: System) -> dict[str, list[float]]:
    return {f"{c.name}_dot": [-1.0, 1.0] for c in machine.coordinates}


def drawn_bodies(mark: object) -> list[bool]:
    assert isinstance(mark, Ghost)
    return [bool(pose.reshape(3, 4)[:, :3].any()) for pose in mark.table]


def test_before_a_plan_only_what_the_goal_decides_is_outlined() -> None:
    _, scene, _ = shown(hand_and_block(), {"bx": 1.0}, {"x": -1.0, "z": 1.0})
    assert drawn_bodies(scene.goal) == [False, True]
    _, scene, _ = shown(hand_and_block(), {"bx": 1.0, "x": 0.5, "z": 0.5}, {})
    assert drawn_bodies(scene.goal) == [True, True]


def test_what_the_goal_leaves_free_is_as_at_the_end_of_the_plan() -> None:
    _, scene, _ = shown(
        hand_and_block(), {"bx": 1.0}, {"x": -1.0}, {"x": 0.7, "z": 1.2, "bx": 0.98}
    )
    assert drawn_bodies(scene.goal) == [True, True]
    np.testing.assert_allclose(scene.goal.table[:, 3::4], [[0.7, 0, 1.2], [1.0, 0, 0.05]])


def test_a_turn_that_one_does_not_see_hides_nothing() -> None:
    _, scene, _ = shown(wheel(), {"x": 1.0}, {})
    assert drawn_bodies(scene.goal) == [True]


def test_a_goal_of_velocities_alone_has_no_place() -> None:
    _, scene, _ = shown(hand_and_block(), {"x_dot": 0.5}, {})
    assert scene.goal is None


def test_a_goal_of_x_and_y_is_a_region() -> None:
    x, y = length("x", -1, 1), length("y", -1, 1)
    ball = Body("ball", move(x, y, 0.1) @ rot_z(0), mass=1.0, shape=Sphere(0.1))
    _, scene, _ = shown(System("ball", bodies=[ball]), {"x": 0.5, "y": 0.5}, {})
    assert isinstance(scene.goal, GoalMarker)


@pytest.mark.parametrize(("heights", "rolls"), [((0.0, 0.0), True), ((0.0, 1.0), False)])
def test_a_path_is_a_track_only_while_the_body_is_as_low_as_itself(
    heights: tuple[float, float], rolls: bool
) -> None:
    states = [{"x": 0.0, "z": heights[0]}, {"x": 1.0, "z": heights[1]}]
    _, scene, _ = shown(hand_and_block(), {"bx": 1.0}, *states, world={"ground": "plane"})
    assert scene.rolls is rolls


def test_the_path_is_that_of_a_body_that_goes_somewhere() -> None:
    """Not of a beam that turns in its place."""
    a, r = angle("a"), length("r", -1, 1)
    beam = Body("beam", rot_y(a), inertia=1.0, shape=Box(1, 0.1, 0.1))
    ball = Body("ball", rot_y(a) @ move(r, 0, 0.1), mass=1.0, shape=Sphere(0.05))
    _, scene, _ = shown(System("seesaw", bodies=[beam, ball]), {"r": 0.5}, {"r": -0.5}, {"r": 0.5})
    np.testing.assert_allclose(scene.path[:, 0], [-0.5, 0.5])


@pytest.mark.parametrize("axes", [False, True])
def test_axes_are_drawn_where_they_are_asked_for(axes: bool) -> None:
    """Each colour is one that nothing else in this picture has."""
    problem, scene, x = shown(wheel(), {"x": 1.0}, {}, render={"axes": axes, "view": "perspective"})
    script = write_script(scene, [0.0], problem.model.frames(x), size=(320, 240))
    image = staged(script).frame(0).reshape(-1, 3).astype(int)
    for color in (X, Y, Z):
        near = np.abs(image - np.array(color)).max(axis=1) < 12  # [of 255]; edges are mixed
        assert bool(near.any()) is axes
    assert (scene.frames is not None) is axes
    if axes:
        assert scene.frames.names == ("world", "x", "wheel")


@pytest.mark.parametrize(("height", "rolls"), [(0.9, False), (0.03, True)])
def test_a_long_plank_on_a_high_pivot_leaves_no_track_on_the_ground(
    height: float, rolls: bool
) -> None:
    """It reaches farther than it is high above the ground, and is in the air all the same."""
    tilt, s = angle("tilt", -0.3, 0.3), length("s", -1, 1)
    plank = Body(
        "plank", move(s, 0, height) @ rot_y(tilt), mass=1.0, inertia=0.5, shape=Box(2.4, 0.3, 0.04)
    )
    machine = System("plank", bodies=[plank])
    ground = {"world": {"ground": "plane"}}
    _, drawn, _ = shown(machine, {"s": 0.5}, {"s": 0.0}, {"s": 0.5}, **ground)
    assert drawn.rolls is rolls
