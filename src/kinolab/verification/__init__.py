"""Verification of plans by a re-simulation that shares nothing with the planners."""

from kinolab.verification.certificate import (
    Certificate,
    collision_check,
    dynamics_checks,
    verify,
)
from kinolab.verification.checks.check import Check

__all__ = ["Certificate", "Check", "collision_check", "dynamics_checks", "verify"]
