"""Why not? What stopped a search that found no plan, for any planner."""

from kinolab.analyze.diagnose.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
