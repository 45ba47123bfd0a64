"""The benchmark's machines: its order of numbers, its metric and its time step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

GROUND, FLYING = 0.1, 0.01  # [s] time steps
ROTATION = "R"  # the one coordinate that is four numbers, a quaternion x, y, z, w


@dataclass(frozen=True)
class KnownMachine:
    """What the benchmark says of a machine beyond its dynamics.

    Attributes:
        weights: Of each coordinate and rate in its distance, in the order of its numbers; a
            rotation's is that of half the angle.
        step: Of explicit Euler, in [s].
        view: From where a picture of it says most.
    """

    weights: dict[str, float]
    step: float
    view: Literal["top", "front", "perspective"]

    @property
    def dimension(self) -> int:
        """Of the world that it moves in: 2 or 3."""
        return 3 if "z" in self.weights else 2

    @property
    def numbers(self) -> tuple[str, ...]:
        """The names of the numbers of a state, in order."""
        return tuple(
            entry
            for name in self.weights
            for entry in ([f"{name}_{axis}" for axis in "xyzw"] if name == ROTATION else [name])
        )


_UNICYCLE = KnownMachine({"x": 1.0, "y": 1.0, "theta": 0.5}, GROUND, "top")
_QUADROTOR = KnownMachine(
    {
        **dict.fromkeys(("x", "y", "z"), 1.0),
        ROTATION: 0.5,
        **dict.fromkeys(("x_dot", "y_dot", "z_dot"), 0.1),
        **dict.fromkeys(("R_wx", "R_wy", "R_wz"), 0.05),
    },
    FLYING,
    "perspective",
)

MACHINES: dict[str, KnownMachine] = {
    **dict.fromkeys(("unicycle1_v0", "unicycle1_v1", "unicycle1_v2"), _UNICYCLE),
    "unicycle2_v0": KnownMachine(_UNICYCLE.weights | {"v": 0.25, "w": 0.25}, GROUND, "top"),
    "car1_v0": KnownMachine({"x": 1.0, "y": 1.0, "theta_0": 0.5, "theta_1": 0.5}, GROUND, "top"),
    "acrobot_v0": KnownMachine(
        {"q1": 0.5, "q2": 0.5, "q1_dot": 0.2, "q2_dot": 0.2}, FLYING, "front"
    ),
    "quad2d_v0": KnownMachine(
        {"x": 1.0, "y": 1.0, "theta": 0.5} | dict.fromkeys(("x_dot", "y_dot", "theta_dot"), 0.2),
        FLYING,
        "front",
    ),
    "quad2dpole_v0": KnownMachine(
        {"x": 1.0, "y": 1.0, "theta": 0.5, "q": 0.5}
        | dict.fromkeys(("x_dot", "y_dot", "theta_dot", "q_dot"), 0.2),
        FLYING,
        "front",
    ),
    **dict.fromkeys(("quad3d_v0", "quad3d_omplapp"), _QUADROTOR),
}
