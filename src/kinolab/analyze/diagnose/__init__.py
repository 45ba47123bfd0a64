"""Diagnosis of failed searches, for any planner."""

from kinolab.analyze.diagnose.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
