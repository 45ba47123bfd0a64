"""One step of a machine and whether it may be made; what every planner is built on."""

from kinolab.simulation.candidate_rollouts import Rollouts
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.simulation.continuous_collision import Sweep
from kinolab.simulation.propagator import Propagator
from kinolab.simulation.reference_step import TrueStep
from kinolab.simulation.rejections import Rejections
from kinolab.simulation.stability import Stiffness, fading, stiffness, too_long
from kinolab.simulation.zero_order_hold import HeldInputs

__all__ = [
    "CompiledStep",
    "HeldInputs",
    "Propagator",
    "Rejections",
    "Rollouts",
    "Stiffness",
    "Sweep",
    "TrueStep",
    "fading",
    "stiffness",
    "too_long",
]
