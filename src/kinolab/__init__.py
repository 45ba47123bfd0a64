"""Motion planning for machines whose equations of motion are derived, not typed in."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinolab import systems
    from kinolab.analyze.diagnose import Diagnosis, diagnose
    from kinolab.loading import load
    from kinolab.problem import Problem
    from kinolab.show.view import save_glb, save_page
    from kinolab.solve import Plan
    from kinolab.trajectory import Trajectory
    from kinolab.verification import Certificate, verify

__version__ = "0.1.0.dev0"

__all__ = [
    "Certificate",
    "Diagnosis",
    "Plan",
    "Problem",
    "Trajectory",
    "diagnose",
    "load",
    "save_glb",
    "save_page",
    "systems",
    "verify",
]

_HOMES = {
    "Certificate": "kinolab.verification.certificate",
    "Diagnosis": "kinolab.analyze.diagnose",
    "Plan": "kinolab.solve",
    "Problem": "kinolab.problem.task",
    "Trajectory": "kinolab.trajectory.trajectory",
    "diagnose": "kinolab.analyze.diagnose",
    "load": "kinolab.loading",
    "save_glb": "kinolab.show.view",
    "save_page": "kinolab.show.view",
    "verify": "kinolab.verification.certificate",
}


def __getattr__(name: str) -> Any:
    """Import late, so that ``plan --help`` answers at once."""
    if name == "systems":
        return import_module("kinolab.systems")
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'kinolab' has no attribute {name!r}")
