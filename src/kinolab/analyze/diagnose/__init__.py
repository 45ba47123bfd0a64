"""Diagnosis of failed searches, for any planner."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
    from kinolab.analyze.diagnose.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]

# a page asks for inputs that hold a machine, and needs no diagnosis
__getattr__ = lazy_names(
    __name__, {"kinolab.analyze.diagnose.diagnosis": ("Diagnosis", "diagnose")}
)
