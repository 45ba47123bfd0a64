"""Diagnosis of failed searches, for any planner."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.analyze.diagnose.diagnosis import Diagnosis as Diagnosis
    from kinolab.analyze.diagnose.diagnosis import diagnose as diagnose

# a page asks for inputs that hold a machine, and needs no diagnosis
__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)
