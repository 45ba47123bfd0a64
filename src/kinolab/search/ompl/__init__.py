"""OMPL interface: problems as OMPL objects, and OMPL's planners.

Properties of OMPL 2.0.1's wheel that shape these files: propagation and validity may be callables,
goals must be subclassed; a compound space keeps C++ distances; ``copyFromReals`` is safe only after
``setup``; states must not be kept beyond a callback; OMPL's references to Python callables are
invisible to the garbage collector, so no callback may refer to the space information or the problem
definition. Lists are passed as copies, states and inputs are not.
"""

from kinolab.search.ompl.control_search import search as search
from kinolab.search.ompl.ompl_planner import OmplPlanner as OmplPlanner
from kinolab.search.ompl.simple_setup import OmplSetup as OmplSetup
from kinolab.search.ompl.syclop_planner import AbstractSyclopPlanner as AbstractSyclopPlanner
from kinolab.search.ompl.tree_planner import AbstractGridPlanner as AbstractGridPlanner
from kinolab.search.ompl.tree_planner import AbstractTreePlanner as AbstractTreePlanner
