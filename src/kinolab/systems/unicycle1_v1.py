"""The unicycle of dynobench, first order, variant 1."""

from kinolab.dynamics import System
from kinolab.systems._unicycle1 import unicycle1


def unicycle1_v1() -> System:
    """A robot that cannot stop: its speed and turn rate are given (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v1.yaml.
    """
    return unicycle1("unicycle1_v1", v=(0.25, 0.5), w=0.5)
