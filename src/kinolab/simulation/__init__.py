"""Simulation: propagation, rollouts, continuous collision checking and reference integration."""

from kinolab.lazy import lazy_package
from kinolab.simulation.compiled_step import CompiledStep as CompiledStep
from kinolab.simulation.compiled_step import ReferenceStep as ReferenceStep
from kinolab.simulation.propagator import Propagator as Propagator
from kinolab.simulation.propagator import Rejections as Rejections
from kinolab.simulation.rollout import CandidateRollouts as CandidateRollouts
from kinolab.simulation.rollout import ZeroOrderHold as ZeroOrderHold
from kinolab.simulation.stability import Stiffness as Stiffness
from kinolab.simulation.stability import decay_rate as decay_rate
from kinolab.simulation.stability import step_too_long as step_too_long
from kinolab.simulation.stability import stiffness as stiffness

__all__, *_ = lazy_package(__name__, __file__)  # what it imports as itself
