"""What pushes the joints of a robot, and what resists them along tendons, as files describe it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class Motor:
    """A motor of a joint: an input within limits, which times ``gear`` is in [N m] or [N]."""

    name: str
    joint: str
    lower: float
    upper: float
    gear: float = 1.0


@dataclass(frozen=True)
class Length:
    """A sum of positions of joints, such as the length of a fixed tendon.

    Attributes:
        joints: By how much it grows with each joint, by name.
        offset: What is added to the sum, such as by joints that are held.
    """

    joints: Mapping[str, float]
    offset: float = 0.0

    def beside(self, held: Mapping[str, float]) -> Length:
        """Return the length where some of its joints are held at positions."""
        still = sum(each * held[name] for name, each in self.joints.items() if name in held)
        moving = {name: each for name, each in self.joints.items() if name not in held}
        return Length(moving, self.offset + still)


@dataclass(frozen=True)
class Filter:
    """What stands between a command and the force: a state that follows the command.

    Attributes:
        time_constant: Of a lag of first order, in [s]; None of an integral of the command.
        lower, upper: Limits of the state.
    """

    time_constant: float | None
    lower: float
    upper: float


@dataclass(frozen=True)
class Thruster:
    """An input within limits that pushes and turns a link.

    Attributes:
        name: Its name.
        link: Name of the link.
        pose: Of its own frame in the link's, shape (4, 4).
        force, torque: For each unit of the input, in its frame's axes at its origin, shape (3,), in
            [N] and [N m].
        lower, upper: Limits of the input.
        filter: Whose state pushes instead of the input, if any.
    """

    name: str
    link: str
    pose: Array
    force: Array
    torque: Array
    lower: float
    upper: float
    filter: Filter | None = None


@dataclass(frozen=True)
class Actuator:
    """An input within limits that acts along a length: a servo, or a motor of several joints.

    Its force is (g0 + g1 L + g2 L_dot) u + bias - stiffness L - damping L_dot along the length L,
    where u is the input, or the state that follows it.

    Attributes:
        name: Its name.
        along: L.
        lower, upper: Limits of the input.
        gain: g0, g1, g2.
        bias, stiffness, damping: The force without an input.
        least, most: Limits of the force, which motions keep.
        filter: Whose state acts instead of the input, if any.
    """

    name: str
    along: Length
    lower: float
    upper: float
    gain: tuple[float, float, float] = (1.0, 0.0, 0.0)
    bias: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    least: float = -math.inf
    most: float = math.inf
    filter: Filter | None = None


@dataclass(frozen=True)
class Aim:
    """What a servo whose input is its force can do where it is.

    It pushes with a - stiffness L - damping L_dot for any a in [lower, upper], clipped to
    [least, most]: that is its input.

    Attributes:
        input: Name of its input.
        along: Its length L.
        lower, upper: Ends of what it can aim at, as inputs where L and L_dot are zero.
        stiffness, damping: In units of its input for each of L and of L_dot.
        least, most: Limits of its input.
    """

    input: str
    along: Length
    lower: float
    upper: float
    stiffness: float
    damping: float
    least: float
    most: float


@dataclass(frozen=True)
class Tendon:
    """What resists the change of a length of joints.

    Attributes:
        name: Its name.
        along: Its length L.
        stiffness: Coefficients of x, x^2, …, by how much L is beyond its rest, in SI units.
        rest: Between which lengths it is slack.
        damping: Coefficients of L_dot, L_dot |L_dot|, …, in SI units.
        friction: Coulomb friction.
        armature: Inertia that only its length feels.
        lower, upper: Limits of L.
    """

    name: str
    along: Length
    stiffness: tuple[float, ...] = ()
    rest: tuple[float, float] = (0.0, 0.0)
    damping: tuple[float, ...] = ()
    friction: float = 0.0
    armature: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
