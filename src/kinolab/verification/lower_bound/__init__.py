"""A proved lower bound on the duration of every plan of a problem."""

from kinolab.verification.lower_bound.duration_bound import DurationBound as DurationBound
from kinolab.verification.lower_bound.duration_bound import duration_bound as duration_bound
