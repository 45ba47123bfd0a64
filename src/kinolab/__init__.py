"""Motion planning for machines whose equations of motion are derived, not typed in."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinolab import systems
    from kinolab.analyze.diagnose import Diagnosis, diagnose
    from kinolab.api import Plan, Problem, load
    from kinolab.show.view import save_glb, save_page
    from kinolab.trajectory import Trajectory
    from kinolab.verification import Certificate, verify

    __version__: str

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
    "Certificate": "kinolab.verification.certificate.Certificate",
    "Diagnosis": "kinolab.analyze.diagnose.Diagnosis",
    "Plan": "kinolab.api.Plan",
    "Problem": "kinolab.api.Problem",
    "Trajectory": "kinolab.trajectory.trajectory.Trajectory",
    "diagnose": "kinolab.analyze.diagnose.diagnose",
    "load": "kinolab.api.load",
    "save_glb": "kinolab.show.view.save_glb",
    "save_page": "kinolab.show.view.save_page",
    "verify": "kinolab.verification.certificate.verify",
}


def __getattr__(name: str) -> Any:
    """Import lazily, so that ``plan --help`` starts fast."""
    if name == "systems":
        return import_module("kinolab.systems")
    if name == "__version__":
        return import_module("importlib.metadata").version("kinolab")
    if name in _HOMES:
        module, _, own = _HOMES[name].rpartition(".")
        value = getattr(import_module(module), own)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'kinolab' has no attribute {name!r}")
