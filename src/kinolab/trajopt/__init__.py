"""Trajectory optimisation after the search: exact goals and shorter durations."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.trajopt.exact.exact import make_exact as make_exact
    from kinolab.trajopt.exact.segments import is_long as is_long
    from kinolab.trajopt.multistart.lazy_roadmap import least_duration as least_duration
    from kinolab.trajopt.nlp.problem import most_time as most_time
    from kinolab.trajopt.shortening.cheapening import cheapened as cheapened
    from kinolab.trajopt.shortening.shorten import shorten as shorten
    from kinolab.trajopt.shortening.shorten import shortened as shortened
    from kinolab.trajopt.sqp.minimum_cost import subproblem_seconds as subproblem_seconds

# a search needs none of it
__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)
