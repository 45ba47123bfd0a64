"""One step of a machine and whether it may be made; what every planner is built on."""

from kinolab.propagation.compiled_step import CompiledStep
from kinolab.propagation.held_inputs import HeldInputs
from kinolab.propagation.propagator import Propagator
from kinolab.propagation.rejections import Rejections
from kinolab.propagation.rollouts import Rollouts
from kinolab.propagation.stability import Stiffness, fading, stiffness, too_long
from kinolab.propagation.sweep import Sweep
from kinolab.propagation.true_step import TrueStep

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
