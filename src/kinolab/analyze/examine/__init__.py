"""``plan examine``: laws of mechanics checked on a machine, and what looks wrong about it."""

from kinolab.analyze.examine.examination import examine, modes_alone
from kinolab.analyze.examine.law_check import LawCheck

__all__ = ["LawCheck", "examine", "modes_alone"]
