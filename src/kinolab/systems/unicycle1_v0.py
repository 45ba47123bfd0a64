"""The unicycle of dynobench, first order, variant 0."""

from kinolab.dynamics import System
from kinolab.systems._unicycle1 import unicycle1


def unicycle1_v0() -> System:
    """A robot that is moved at a given speed and turn rate (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v0.yaml.
    """
    return unicycle1("unicycle1_v0", v=0.5, w=0.5)
