"""Simulation: propagation, rollouts, continuous collision checking and reference integration."""

from kinolab.simulation.compiled_step import CompiledStep, ReferenceStep
from kinolab.simulation.continuous_collision import ContinuousCollisionCheck
from kinolab.simulation.propagator import Propagator, Rejections
from kinolab.simulation.rollout import CandidateRollouts, ZeroOrderHold
from kinolab.simulation.stability import Stiffness, decay_rate, step_too_long, stiffness

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
