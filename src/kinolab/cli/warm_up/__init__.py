"""Everything compiled ahead of time, so that no plan has to wait for it."""

from kinolab.cli.warm_up.parts import PARTS
from kinolab.cli.warm_up.warming import Warmed, warm_up

__all__ = ["PARTS", "Warmed", "warm_up"]
