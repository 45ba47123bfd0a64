"""A problem as OMPL objects, and OMPL's planners run on it.

Facts about OMPL 2.0.1's wheel that shape these files: callables may be given for propagation and
validity, while goals must be subclassed; a compound space keeps C++ distances; ``copyFromReals``
is safe only after ``setup``; states must not be kept beyond a callback; OMPL's objects hold Python
callables in a way the garbage collector cannot see, so that nothing called back may refer to the
space information or the problem definition. Lists are handed over as copies, states and inputs
are not.
"""

from kinolab.search.ompl.configuration_space import ConfigurationSpace
from kinolab.search.ompl.control_search import search
from kinolab.search.ompl.geometric_roadmap import GeometricRoadmap
from kinolab.search.ompl.ompl_planner import OmplPlanner
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.ompl.syclop.syclop_planner import AbstractSyclopPlanner
from kinolab.search.ompl.tree_planner import AbstractGridPlanner, AbstractTreePlanner

__all__ = [
    "AbstractGridPlanner",
    "AbstractSyclopPlanner",
    "AbstractTreePlanner",
    "ConfigurationSpace",
    "GeometricRoadmap",
    "OmplPlanner",
    "OmplSetup",
    "search",
]
