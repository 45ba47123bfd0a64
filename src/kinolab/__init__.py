"""Motion planning for machines whose equations of motion are derived, not typed in."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab import systems as systems
    from kinolab.analyze.diagnose import Diagnosis as Diagnosis
    from kinolab.analyze.diagnose import diagnose as diagnose
    from kinolab.api import Plan as Plan
    from kinolab.api import Problem as Problem
    from kinolab.api import examine as examine
    from kinolab.api import load as load
    from kinolab.api import read_run as read_run
    from kinolab.api import simulate as simulate
    from kinolab.show.view import save_glb as save_glb
    from kinolab.show.view import save_page as save_page
    from kinolab.trajectory.trajectory import Trajectory as Trajectory
    from kinolab.verification.certificate import Certificate as Certificate
    from kinolab.verification.certificate import verify as verify

    __version__: str

_MODULES = (
    *("dynamics", "errors", "gym", "interchange"),
    *("planners", "robots", "systems", "testing"),
)
__all__, _lazy, __dir__ = lazy_package(__name__, __file__, *_MODULES, "__version__")


def __getattr__(name: str) -> Any:
    """Import lazily, so that ``plan --help`` starts fast."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    if name == "__version__":
        return import_module("importlib.metadata").version("kinolab")
    return _lazy(name)
