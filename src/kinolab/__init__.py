"""Motion planning for machines whose equations of motion are derived, not typed in."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from kinolab.lazy import lazy_names, public_names

if TYPE_CHECKING:
    from kinolab import systems
    from kinolab.analyze.diagnose import Diagnosis, diagnose
    from kinolab.api import Plan, Problem, load, read_run, simulate
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
    "read_run",
    "save_glb",
    "save_page",
    "simulate",
    "systems",
    "verify",
]

_lazy = lazy_names(
    __name__,
    {
        "kinolab.analyze.diagnose": ("Diagnosis", "diagnose"),
        "kinolab.api": ("Plan", "Problem", "load", "read_run", "simulate"),
        "kinolab.show.view": ("save_glb", "save_page"),
        "kinolab.trajectory.trajectory": ("Trajectory",),
        "kinolab.verification.certificate": ("Certificate", "verify"),
    },
)

_MODULES = ("dynamics", "errors", "planners", "systems", "testing")
__dir__ = public_names(__name__, *_MODULES, "__version__")


def __getattr__(name: str) -> Any:
    """Import lazily, so that ``plan --help`` starts fast."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    if name == "__version__":
        return import_module("importlib.metadata").version("kinolab")
    return _lazy(name)
