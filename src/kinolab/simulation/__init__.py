"""One step of a machine and whether it may be made; what every planner is built on."""

from kinolab.simulation.candidate_rollouts import CandidateRollouts
from kinolab.simulation.compiled_step import CompiledStep, ReferenceStep
from kinolab.simulation.continuous_collision import ContinuousCollisionCheck
from kinolab.simulation.propagator import Propagator
from kinolab.simulation.rejections import Rejections
from kinolab.simulation.stability import Stiffness, decay_rate, step_too_long, stiffness
from kinolab.simulation.zero_order_hold import ZeroOrderHold

__all__ = [
    "CandidateRollouts",
    "CompiledStep",
    "ContinuousCollisionCheck",
    "Propagator",
    "ReferenceStep",
    "Rejections",
    "Stiffness",
    "ZeroOrderHold",
    "decay_rate",
    "step_too_long",
    "stiffness",
]
