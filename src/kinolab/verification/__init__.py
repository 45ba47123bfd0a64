"""Is a plan true? Judged on a re-simulation that shares nothing with the planners."""

from kinolab.verification.certificate import (
    Certificate,
    Check,
    collision_check,
    dynamics_checks,
    verify,
)

__all__ = ["Certificate", "Check", "collision_check", "dynamics_checks", "verify"]
