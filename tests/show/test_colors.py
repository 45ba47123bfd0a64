"""Colours that carry meaning can be told apart, by the colour-blind too, and words can be read."""

from __future__ import annotations

import itertools
import re
from importlib.resources import files

import numpy as np
import pytest

from kinolab.show.scene.models.cone import FORBIDDEN, STRIPE, WANTED
from kinolab.show.scene.models.setting import SETTINGS
from kinolab.show.scene.still import GOAL, PATH, START

# Machado, Oliveira, Fernandes, A Physiologically-based Model for Simulation of Color Vision
# Deficiency, IEEE TVCG 15(6), 2009, severity 1: of linear red, green and blue.
EYES = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
}
XYZ = np.array(  # of linear sRGB, IEC 61966-2-1
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
WHITE = XYZ @ np.ones(3)
APART = 20.0  # CIE 1976 difference; 2.3 is just noticeable side by side
READABLE = 4.5  # WCAG 2.2, 1.4.3
VISIBLE = 3.0  # WCAG 2.2, 1.4.11, of what is drawn
PAGE = files("kinolab.show.page")

Color = tuple[float, float, float]


def linear(color: Color) -> np.ndarray:
    c = np.asarray(color, dtype=float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(color: Color, eye: str) -> np.ndarray:
    seen = np.clip(EYES[eye] @ linear(color), 0.0, 1.0)
    t = XYZ @ seen / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(a: Color, b: Color) -> float:
    bright = sorted(float(XYZ[1] @ linear(color)) for color in (a, b))
    return (bright[1] + 0.05) / (bright[0] + 0.05)


def rgb(text: str) -> Color:
    digits = text.removeprefix("#").removeprefix("0x")
    red, green, blue = (int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4))
    return red, green, blue


def apart(a: Color, b: Color) -> float:
    return min(float(np.linalg.norm(lab(a, eye) - lab(b, eye))) for eye in EYES)


def themes() -> dict[str, dict[str, Color]]:
    """The colours of the page's text by theme and name."""
    text = PAGE.joinpath("page.css").read_text()
    blocks = re.findall(r":root(\[data-theme=\"dark\"\])? \{(.*?)\}", text, re.DOTALL)
    found = {}
    for dark, block in blocks[:2]:
        pairs = re.findall(r"--([\w-]+): (#[0-9a-f]{6})", block)
        found["dark" if dark else "light"] = {name: rgb(value) for name, value in pairs}
    return found


def paints(theme: str) -> dict[str, Color]:
    """The colours of the page's scene by name."""
    text = PAGE.joinpath("theme.js").read_text()
    block = re.search(rf"  {theme}: \{{(.*?)\}}", text, re.DOTALL)
    assert block is not None
    return {name: rgb(value) for name, value in re.findall(r"(\w+): (0x[0-9a-f]{6})", block[1])}


MEANINGS: dict[str, Color] = {
    "start": START,
    "goal": GOAL,
    "path": (PATH[0] / 255, PATH[1] / 255, PATH[2] / 255),
    "keep out": FORBIDDEN,
}


@pytest.mark.parametrize("pair", list(itertools.combinations(MEANINGS, 2)), ids=" and ".join)
def test_start_goal_way_and_forbidden_cones_can_be_told_apart(pair: tuple[str, str]) -> None:
    assert apart(MEANINGS[pair[0]], MEANINGS[pair[1]]) > APART


def test_a_forbidden_cone_is_told_by_its_stripes_too() -> None:
    assert apart(FORBIDDEN, STRIPE) > APART
    assert apart(WANTED, STRIPE) > APART


@pytest.mark.parametrize("setting", list(SETTINGS))
def test_the_way_is_seen_on_every_floor(setting: str) -> None:
    floor = SETTINGS[setting].floor  # type: ignore[index]
    assert apart(floor, MEANINGS["path"]) > APART
    assert apart(floor, GOAL) > APART


@pytest.mark.parametrize("setting", list(SETTINGS))
def test_words_can_be_read_before_every_sky(setting: str) -> None:
    colors = SETTINGS[setting]  # type: ignore[index]
    for edge in colors.sky:
        assert contrast(colors.words, edge) > READABLE


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_pages_words_can_be_read(theme: str) -> None:
    colors = themes()[theme]
    for word, ground in [
        *itertools.product(("ink", "soft", "bad", "good"), ("paper", "panel")),
        *itertools.product(("ink",), ("fill",)),
        *[(kind, f"{kind}-fill") for kind in ("good", "bad", "fair")],
        ("on-accent", "accent"),
    ]:
        assert contrast(colors[word], colors[ground]) > READABLE, (word, ground)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_way_so_far_and_the_way_to_come_can_be_told_apart(theme: str) -> None:
    colors = paints(theme)
    assert apart(colors["path"], colors["ahead"]) > APART
    assert contrast(colors["path"], colors["floor"]) > VISIBLE


def test_the_axes_can_be_told_apart() -> None:
    text = PAGE.joinpath("page.css").read_text()
    axes = [rgb(value) for value in re.findall(r"\.axes line\.[xyz] \{ stroke: (#\w{6})", text)]
    assert len(axes) == 3
    assert all(apart(a, b) > APART for a, b in itertools.combinations(axes, 2))
