"""The unicycle of dynobench, first order, variant 2."""

from kinolab.dynamics import System
from kinolab.systems._unicycle1 import unicycle1


def unicycle1_v2() -> System:
    """A robot that cannot stop and turns left better than right (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v2.yaml.
    """
    return unicycle1("unicycle1_v2", v=(0.25, 0.5), w=(-0.25, 0.5))
