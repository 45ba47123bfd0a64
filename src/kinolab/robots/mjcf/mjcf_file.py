"""Reading MJCF files, MuJoCo's models, by MuJoCo itself.

Source: MuJoCo's documentation, XML reference and chapter Computation (joints, actuators, passive
forces, equality constraints).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from kinolab.arguments import require_fit
from kinolab.dynamics import System
from kinolab.errors import InputError
from kinolab.robots.machine.given_motion import PerJoint, given_motion
from kinolab.robots.machine.robot_machine import assembled
from kinolab.robots.mjcf.compiled_model import CompiledModel
from kinolab.robots.mjcf.mjcf_geoms import GeomReader
from kinolab.robots.mjcf.mjcf_tree import tree_of
from kinolab.robots.solids.convex_parts import check_parts
from kinolab.robots.tree.tree_mistakes import tree_mistakes


def read_mjcf(
    path: str | Path,
    *,
    locked: Mapping[str, float] | None = None,
    shapes: bool = True,
    self_collisions: bool = True,
    convex_parts: int | None = None,
    partial: bool = False,
    servo_commands: bool = False,
    kinematic: bool = False,
    max_velocity: PerJoint | None = None,
    max_acceleration: PerJoint | None = None,
) -> System:
    """Read a robot from an MJCF file as a machine.

    Bodies without joints are fixed to their parents. A motor's limit is that of its control, times
    gain and gear, or that of its force or of its joint's. A servo is a spring and a damper whose
    input is its command; where its force has limits the input is that force, and requirements say
    what its gain and ``ctrlrange`` let it do where it is. Integrators and filters have states of
    their own. Fixed tendons and their actuators act on all joints of these. Springs, friction and
    rotors (``armature``) of joints count, and so does weight that is borne (``gravcomp``); ranges
    of ball joints and of tendons are requirements of the machine. Contacts between bodies do not
    push, as in all of kinolab. Flags that disable forces, limits or actuators do so; solids keep
    apart all the same where a flag disables contacts. What is fixed to the world is not touched,
    but by what rests on it or turns about it; planes are walls and floors, except the ground z = 0,
    which a scenario has or not. Bodies that are connected or welded to others close loops, exactly
    instead of softly. Geoms that collide count, or those that are drawn where a body has none;
    meshes and ellipsoids are enclosed in boxes and capsules. Warnings name mocap bodies, keyframes
    and the ground, which are not read.

    Args:
        locked: Positions of joints that do not move, by name, in [rad] or [m].
        shapes: Whether to read shapes at all.
        self_collisions: Whether bodies may not touch each other: those that can and are not
            neighbours, nor of one robot and touch at rest, or may by the file's ``contype``,
            ``conaffinity``, ``<exclude>`` and ``<pair>``.
        convex_parts: How many parts a mesh may be divided into, each with a box or capsule of its
            own, instead of one around the whole.
        partial: Whether to leave out what cannot be represented.
        servo_commands: Whether commands are the inputs of servos whose forces have limits, too, in
            which requirements keep the forces. A plan holds each command for a step, in which a
            stiff servo may move but a little.
        kinematic: Whether the speeds of joints are its inputs, whatever forces that takes. Masses,
            friction and actuators have no part in its motion then.
        max_velocity: Of a kinematic robot: limits of joints, which MJCF has none of, of all or by
            name, in [rad/s] or [m/s].
        max_acceleration: Of a kinematic robot: limits of accelerations, in [rad/s^2] or [m/s^2],
            which are the inputs then.

    Raises:
        InputError: With everything in the file that cannot be represented, such as muscles or a
            fluid, unless ``partial``, and with numbers that are not finite. All of MuJoCo's model
            is looked at, so that nothing is left out in silence. With the joint at which the
            machine moves otherwise than MuJoCo's own model, unless something is left out.
    """
    require_fit("read_mjcf path", str | Path, path)
    require_fit("read_mjcf locked", Mapping[str, float] | None, locked)
    path = Path(path)
    given = given_motion(path.name, max_velocity, max_acceleration, kinematic=kinematic)
    check_parts(convex_parts, path.name)
    compiled = CompiledModel(path)
    tree = tree_of(
        compiled,
        GeomReader(compiled, shapes=shapes, convex_parts=convex_parts),
        commands=servo_commands,
    )
    mistakes = [*tree_mistakes(tree, locked or {}, path.name)]
    if not partial:
        mistakes += compiled.left_out
    if mistakes:
        raise InputError(mistakes)
    return assembled(
        tree,
        locked=locked,
        self_collisions=self_collisions,
        where=path.name,
        file=compiled.content(),
        engines=compiled.engines(),
        given=given,
    )
