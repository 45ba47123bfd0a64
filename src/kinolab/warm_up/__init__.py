"""Everything compiled ahead of time, so that no plan has to wait for it."""

from kinolab.warm_up.parts import PARTS
from kinolab.warm_up.warming import Warmed, warm_up

__all__ = ["PARTS", "Warmed", "warm_up"]
