"""Where a scene seems to be: the colours of ground, sky and obstacles, for film, page and GLB."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from kinolab.show.scene.models.ball import Color

SettingName: TypeAlias = Literal["studio", "hall", "yard", "road", "canyon", "water", "space"]
Pattern: TypeAlias = Literal["grid", "boards", "lane", "none"]


@dataclass(frozen=True)
class SceneColors:
    """The colours of a scene, RGB in 0..1.

    Args:
        sky: Of the background at its upper and its lower edge.
        lines: Of the lines on it.
        pattern: A grid; boards, which lie along the longer side; a road with a broken line in its
            middle and kerbs along its sides; or nothing.
        obstacles: Which obstacles without a colour of their own take in turn.
    """

    sky: tuple[Color, Color]
    floor: Color
    lines: Color
    pattern: Pattern = "grid"
    obstacles: tuple[Color, ...] = ()
    words: Color = (0.15, 0.165, 0.196)

    @property
    def is_dark(self) -> bool:
        """Whether words on it are bright."""
        return sum(self.words) > 1.5

    @property
    def side(self) -> Color:
        """Of the edge of the slab of ground."""
        red, green, blue = (0.93 * part for part in self.floor)
        return red, green, blue


BLUE, SAND, SAGE, CLAY, MAUVE = (
    (0.70, 0.755, 0.815),
    (0.835, 0.765, 0.645),
    (0.68, 0.765, 0.68),
    (0.80, 0.665, 0.60),
    (0.745, 0.70, 0.78),
)
PAPER: Color = (250 / 255, 250 / 255, 248 / 255)
SETTINGS: Mapping[SettingName, SceneColors] = {
    "studio": SceneColors(
        (PAPER, PAPER),
        (0.925, 0.925, 0.905),
        (0.83, 0.83, 0.80),
        obstacles=(BLUE, SAND, SAGE, CLAY, MAUVE),
    ),
    "hall": SceneColors(
        (PAPER, (0.93, 0.925, 0.91)),
        (0.875, 0.765, 0.60),
        (0.80, 0.675, 0.50),
        "boards",
        ((0.80, 0.83, 0.87), (0.62, 0.70, 0.80)),
    ),
    "yard": SceneColors(
        ((0.80, 0.885, 0.965), (0.955, 0.965, 0.955)),
        (0.765, 0.76, 0.74),
        (0.715, 0.71, 0.69),
        obstacles=((0.86, 0.855, 0.83), (0.79, 0.66, 0.54), (0.70, 0.755, 0.815)),
    ),
    "road": SceneColors(
        ((0.74, 0.855, 0.96), (0.945, 0.955, 0.93)),
        (0.50, 0.51, 0.525),
        (0.95, 0.95, 0.93),
        "lane",
        ((0.85, 0.84, 0.81), (0.79, 0.27, 0.22)),
    ),
    "canyon": SceneColors(
        ((0.62, 0.79, 0.95), (0.95, 0.93, 0.86)),
        (0.855, 0.715, 0.53),
        (0.80, 0.65, 0.47),
        "none",
        ((0.80, 0.56, 0.38), (0.72, 0.43, 0.29), (0.84, 0.64, 0.45), (0.66, 0.38, 0.27)),
    ),
    "water": SceneColors(
        ((0.78, 0.91, 0.95), (0.42, 0.64, 0.76)),
        (0.70, 0.72, 0.62),
        (0.62, 0.65, 0.57),
        "none",
        ((0.36, 0.47, 0.50), (0.50, 0.58, 0.55), (0.66, 0.68, 0.60)),
    ),
    "space": SceneColors(
        ((0.075, 0.085, 0.13), (0.13, 0.145, 0.21)),
        (0.20, 0.21, 0.25),
        (0.30, 0.31, 0.36),
        "none",
        ((0.72, 0.75, 0.79), (0.80, 0.73, 0.58)),
        (0.93, 0.94, 0.97),
    ),
}
