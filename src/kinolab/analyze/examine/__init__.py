"""``plan examine``: what a machine does, and what looks wrong about it."""

from kinolab.analyze.examine.examination import Examination, examine
from kinolab.analyze.examine.law_check import LawCheck
from kinolab.analyze.examine.laws import laws, modes_alone
from kinolab.analyze.examine.remarks.remark import Remark

__all__ = ["Examination", "LawCheck", "Remark", "examine", "laws", "modes_alone"]
