"""Angles as people write them: "pi/2", "-3 pi/4", "180 deg", and rates such as "90 deg/s"."""

from __future__ import annotations

import math
import re

# What is taken is not given back (``++``): a text of n blanks would be tried in n^6 ways.
_NUMBER = r"(?>(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?)"
_SHAPE = re.compile(
    rf"(?P<sign>[+-]?)\s*+"
    rf"(?:(?P<factor>{_NUMBER})\s*+(?:/\s*+(?P<under>{_NUMBER}))?+\s*+\*?+)?+\s*+"
    rf"(?P<pi>pi|π)?+\s*+(?:/\s*+(?P<over>{_NUMBER}))?+\s*+"
    rf"(?P<unit>deg(?:rees?)?|°|rad(?:ians?)?)?+\s*+(?P<rate>/\s*+s)?+"
)
EXAMPLES = '"pi/2" or "90 deg"'


class WrittenAngle(float):
    """An angle in [rad], or a rate in [rad/s], that was written as text.

    Attributes:
        text: As it was written.
        unit: "rad" or "rad/s"; empty where it may be either, as of "pi/2".
    """

    text: str
    unit: str


def angle_of(text: str) -> WrittenAngle | None:
    """Read an angle, or a rate of one; None where a text is neither.

    A number alone is neither: outside quotes it is one already.
    """
    found = _SHAPE.fullmatch(text.strip())
    if found is None or not (found["pi"] or (found["factor"] and found["unit"])):
        return None
    degrees = (found["unit"] or "").startswith(("deg", "°"))
    if (degrees and found["pi"]) or (found["rate"] and not found["unit"]):
        return None
    below = float(found["under"] or 1) * float(found["over"] or 1)
    value = float(found["factor"] or 1) * (math.pi if found["pi"] else 1.0)
    value = value / below if below else math.inf
    value = math.radians(value) if degrees else value
    if not math.isfinite(value):
        return None
    angle = WrittenAngle(-value if found["sign"] == "-" else value)
    angle.text = text
    angle.unit = "" if not found["unit"] else "rad/s" if found["rate"] else "rad"
    return angle
