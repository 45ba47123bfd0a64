"""Machines posed by hand in a browser: what the page says of constraints is true in SymPy, too."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from kinolab import cli, systems
from kinolab.dynamics.language.constraints import PositionConstraint
from tests.show.view.browsing import Opener, needs_chromium

pytestmark = needs_chromium


def page_of(machine: str, folder: Path) -> Path:
    page = folder / "machine.html"
    assert cli.run(["view", machine, "--no-browser", "--quiet", "--out", str(page)]) == 0
    return page


@pytest.fixture(scope="module")
def five_bar(browse: Opener, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return browse(page_of("five_bar", tmp_path_factory.mktemp("five_bar")))


@pytest.fixture(scope="module")
def coin(browse: Opener, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return browse(page_of("rolling_disk", tmp_path_factory.mktemp("coin")))


def residuals(page: Any) -> dict[str, str]:
    script = "[...document.querySelectorAll('#pose .residual')].map((row) => row.innerText)"
    return dict(re.split(r"\s*\n\s*", text, maxsplit=1) for text in page.evaluate(script))


@pytest.mark.parametrize(("name", "value"), [("a_l", 0.4), ("f_r", 0.3)])
def test_loops_stay_closed_and_the_slider_that_was_moved_keeps_its_value(
    five_bar: Any, name: str, value: float
) -> None:
    five_bar.evaluate(f"kinolab.pose.set('{name}', {value})")
    machine, state = systems.get("five_bar"), five_bar.evaluate("kinolab.pose.state")
    at = dict(zip(machine.coordinates, state, strict=False))
    assert {c.name: v for c, v in at.items()}[name] == value
    for constraint in machine.constraints:
        assert isinstance(constraint, PositionConstraint)
        gap = constraint.position.subs(at).subs({p: p.default for p in machine.parameters})
        assert abs(float(gap)) < 1e-9  # [m]
    assert set(residuals(five_bar).values()) == {"kept"}


def test_it_says_what_one_coordinate_alone_would_break(coin: Any) -> None:
    """A coin at a heading psi that is pushed along x slips by sin psi and rolls by cos psi."""
    coin.evaluate("() => { kinolab.pose.set('psi', 0.5); kinolab.pose.set('x', 0.1); }")
    found = {name: float(text.split()[2]) for name, text in residuals(coin).items()}
    assert found == pytest.approx(
        {"no sideslip": -math.sin(0.5), "rolling": math.cos(0.5)}, abs=1e-4
    )  # four digits are shown
    coin.evaluate("kinolab.pose.set('psi', 0.6)")
    assert set(residuals(coin).values()) == {"kept"}  # turning on the spot slips nowhere


def test_driving_starts_from_the_pose(coin: Any) -> None:
    coin.evaluate("() => { kinolab.pose.set('x', 0.7); kinolab.drive.start(); }")
    assert coin.evaluate("kinolab.drive.state")[0] == 0.7
    coin.evaluate("kinolab.drive.stop()")


def test_a_key_shows_and_hides_the_frames_with_their_names(coin: Any) -> None:
    seen = "[...document.querySelectorAll('.names:not([hidden]) .frame')].map((e) => e.textContent)"
    assert coin.evaluate(seen) == []
    coin.keyboard.press("a")
    assert coin.evaluate(seen) == ["world", "x, y", "psi", "coin"]
    coin.keyboard.press("a")
    assert coin.evaluate(seen) == []
