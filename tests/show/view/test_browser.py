"""The page in a browser: it plays, is scrubbed and read, and asks nobody for anything.

Chromium draws without a graphics processor here, as on a server. One browser serves all tests.
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import kinolab
from kinolab.simulation.reference import reference_motion
from tests.conftest import Solved
from tests.show.view.browsing import Opener, needs_chromium, until
from tests.support import OPEN, problem_of

NEAR = 1e-4  # [m], and of the entries of rotations
PHONE = {"width": 390, "height": 844}

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def rolled(tmp_path_factory: pytest.TempPathFactory) -> Solved:
    """A coin on a table that is small enough to see the coin from everywhere."""
    small = "world.bounds={ x = [-1.5, 1.5], y = [-1.5, 1.5] }"
    problem = problem_of(tmp_path_factory.mktemp("rolled"), OPEN, small)
    plan = problem.solve(seed=1, max_iterations=20_000)
    assert plan.trajectory is not None
    return Solved(problem, plan, plan.trajectory)


@pytest.fixture(scope="module")
def page_file(rolled: Solved, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "scene.html"
    return kinolab.save_page(rolled.problem, rolled.plan, path)


@pytest.fixture(scope="module")
def opened(browse: Opener, page_file: Path) -> Opener:
    """Open the coin's page, or another one."""

    def open_(path: Path = page_file, **options: Any) -> Any:
        return browse(path, **options)

    return open_


@pytest.fixture(scope="module")
def shared(opened: Opener) -> Any:
    return opened()


@pytest.fixture
def page(shared: Any) -> Any:
    """One page for all tests that do not mind, as it is when it opens."""
    shared.mouse.move(1, 1)
    shared.evaluate("() => { kinolab.pause(); kinolab.speed = 1; kinolab.view('perspective'); }")
    shared.evaluate("kinolab.seek(0)")
    return shared


def picture(page: Any, selector: str = "#stage") -> np.ndarray:
    """What is seen of an element, shape (h, w, 3), in 0..255."""
    with Image.open(io.BytesIO(page.locator(selector).screenshot())) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


def coin_pixels(image: np.ndarray) -> np.ndarray:
    """Rows and columns where the coin's strong orange is, shape (n, 2)."""
    red, green, blue = np.moveaxis(image, -1, 0)
    return np.argwhere((red > 110) & (red > 1.8 * green) & (blue < 0.5 * red))


def test_the_machine_in_the_page_is_where_the_trajectory_has_it(page: Any, rolled: Solved) -> None:
    """At two knots and three times between them, held against DOP853."""
    problem, trajectory = rolled.problem, rolled.trajectory
    motion = reference_motion(problem, trajectory.x[0], trajectory.t, trajectory.inputs)
    last = len(trajectory.u) - 1
    for k, share in [(0, 0.0), (0, 0.37), (last // 2, 0.5), (last // 2 + 2, 0.81), (last, 1.0)]:
        t = float(trajectory.t[k] + share * (trajectory.t[k + 1] - trajectory.t[k]))
        page.evaluate("t => kinolab.seek(t)", t)
        frames = page.evaluate("kinolab.frames()")
        expected = problem.frames(motion.between(k, np.array([t]))[0]).reshape(-1, 3, 4)
        for body, pose in zip(problem.bodies, expected, strict=True):
            frame = np.array(frames[body.name])
            assert np.abs(frame[:3] - pose).max() < NEAR
            assert frame[3].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_it_plays_and_pauses_and_the_machine_goes_on(page: Any) -> None:
    assert page.evaluate("[kinolab.time, kinolab.playing]") == [0, False]
    before = page.evaluate("kinolab.frames().coin")
    page.click("#play")
    until(page, "kinolab.time > 0.1 * kinolab.last")
    until(page, "kinolab.fps() > 0")  # of two pictures at least, and a busy computer draws slowly
    page.click("#play")
    time = page.evaluate("kinolab.time")
    assert page.evaluate("kinolab.frames().coin") != before
    page.wait_for_timeout(150)
    assert page.evaluate("[kinolab.time, kinolab.playing]") == [time, False]


def test_it_moves_at_once_unless_the_reader_minds_motion(opened: Opener) -> None:
    page = opened(reduced_motion="no-preference")
    assert page.evaluate("kinolab.playing") is True
    page.context.close()  # or it would go on playing, at the cost of the other tests
    page = opened(reduced_motion="reduce")
    assert page.evaluate("[kinolab.time, kinolab.playing]") == [0, False]


def test_the_address_opens_at_a_time(opened: Opener) -> None:
    page = opened(fragment="#t=0.25", reduced_motion="no-preference")
    assert page.evaluate("[kinolab.time, kinolab.playing]") == [0.25, False]
    page.evaluate("location.hash = '#t=0.5'")
    until(page, "kinolab.time === 0.5")
    page.context.close()


def test_keys_step_from_knot_to_knot(page: Any, rolled: Solved) -> None:
    knots = rolled.trajectory.t
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("kinolab.time") == pytest.approx(knots[2], abs=1e-12)
    page.evaluate("t => kinolab.seek(t)", float(0.5 * (knots[4] + knots[5])))
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("kinolab.time") == pytest.approx(knots[4], abs=1e-12)
    page.keyboard.press("Shift+ArrowRight")
    assert page.evaluate("kinolab.time") == pytest.approx(knots[14], abs=1e-12)
    page.keyboard.press("End")
    assert page.evaluate("kinolab.time") == pytest.approx(knots[-1], abs=1e-12)
    page.keyboard.press("+")
    assert page.evaluate("kinolab.speed") == 2
    page.keyboard.press("Home")
    page.keyboard.press("Space")
    assert page.evaluate("kinolab.playing") is True
    page.keyboard.press("?")
    assert page.locator("#keys").is_visible()
    page.keyboard.press("Escape")
    assert not page.locator("#keys").is_visible()


def test_the_bar_and_the_plots_set_the_time(page: Any, rolled: Solved) -> None:
    bar = page.locator("#scrub").bounding_box()
    page.mouse.click(bar["x"] + 0.5 * bar["width"], bar["y"] + 0.5 * bar["height"])
    half = 0.5 * rolled.trajectory.t[-1]
    assert page.evaluate("kinolab.time") == pytest.approx(half, rel=0.05)
    area = page.locator(".plot:not([hidden]) .area").first.bounding_box()
    page.mouse.click(area["x"] + 0.25 * area["width"], area["y"] + 5)
    assert page.evaluate("kinolab.time") == pytest.approx(0.5 * half, rel=0.02)


def test_plots_tell_the_values_at_the_cursor(page: Any, rolled: Solved) -> None:
    """Four digits are shown; inputs are those that are held from the knot on."""
    trajectory = rolled.trajectory
    row = len(trajectory.u) // 2
    page.evaluate("t => kinolab.seek(t)", float(trajectory.t[row]))
    shown = dict(
        page.eval_on_selector_all(
            ".plot", "all => all.map(p => [p.dataset.name, p.querySelector('output').innerText])"
        )
    )
    values = dict(zip(trajectory.state_names, trajectory.x[row], strict=True))
    values |= dict(zip(trajectory.control_names, trajectory.u[row], strict=True))
    for name in ("x", "y", "psi", "drive", "steer"):
        told = float(shown[name])
        assert told == pytest.approx(values[name], rel=1e-3, abs=2e-3)


def test_the_verdict_is_told(page: Any, rolled: Solved) -> None:
    certificate = rolled.plan.certificate
    assert certificate is not None
    assert page.inner_text("#badge") == "Solved and verified"
    count = len(certificate.checks)
    assert page.inner_text(".verdict") == f"{count} of {count} checks passed"
    page.click(".checked summary")
    assert page.locator(".checks li.passed").count() == count
    assert page.inner_text("#title") == rolled.problem.scenario.title


def test_following_brings_the_machine_near_and_keeps_it_in_the_middle(page: Any) -> None:
    page.keyboard.press("End")
    far = coin_pixels(picture(page))
    page.keyboard.press("4")
    seen = picture(page)
    near = coin_pixels(seen)
    assert len(near) > 2 * len(far) > 0
    middle = near.mean(axis=0) / seen.shape[:2]
    assert middle == pytest.approx([0.5, 0.5], abs=0.12)


@pytest.mark.parametrize("key", ["0", "1", "2", "3"])
def test_every_view_shows_the_machine(page: Any, key: str) -> None:
    page.keyboard.press(key)
    assert len(coin_pixels(picture(page))) > 20
    assert page.locator("#views [aria-pressed=true]").count() == 1


def test_the_pointer_turns_and_the_wheel_brings_nearer(page: Any) -> None:
    before = picture(page)
    page.mouse.move(300, 300)
    page.mouse.down()
    page.mouse.move(380, 330, steps=3)
    page.mouse.up()
    turned = picture(page)
    assert np.abs(turned - before).mean() > 0.5
    count = len(coin_pixels(turned))
    page.mouse.wheel(0, -400)
    page.wait_for_timeout(50)
    assert len(coin_pixels(picture(page))) > 1.2 * count


def test_names_are_symbols_that_keep_their_name_in_files(page: Any) -> None:
    shown = page.eval_on_selector_all(
        ".chips .symbol", "all => Object.fromEntries(all.map(s => [s.title, s.textContent]))"
    )
    assert shown["psi"] == "ψ"
    assert shown["psi_dot"] == "ψ\u0307"
    assert shown["drive"] == "drive"


def test_start_and_goal_have_signs_where_they_are(page: Any) -> None:
    signs = page.locator("#captions .sign:visible")
    assert sorted(signs.all_inner_texts()) == ["goal", "start"]
    assert {"start", "goal", "path so far", "path ahead"} <= set(
        page.locator("#legend li").all_inner_texts()
    )


def test_a_picture_of_the_scene_can_be_saved(page: Any) -> None:
    with page.expect_download() as download:
        page.keyboard.press("s")
    assert download.value.suggested_filename.endswith("s.png")
    image = np.asarray(Image.open(download.value.path()).convert("RGB"))
    assert len(coin_pixels(image)) > 20


def test_plots_are_zoomed_by_the_wheel_and_tell_what_is_under_the_pointer(
    page: Any, rolled: Solved
) -> None:
    plot = page.locator(".plot:not([hidden])").first
    area, last = plot.locator(".area"), rolled.trajectory.t[-1]
    area.scroll_into_view_if_needed()
    area.hover()
    told = plot.locator("output").inner_text()
    assert float(told.split(" at ")[1].split()[0]) == pytest.approx(0.5 * last, abs=0.06)
    page.mouse.wheel(0, -800)
    page.wait_for_timeout(50)
    first, _, end = plot.locator(".times span").all_inner_texts()
    assert 0.0 < float(first) < 0.5 * last < float(end.split()[0]) < last
    area.dblclick()
    assert plot.locator(".times span").first.inner_text() == "0"


def test_a_slider_keeps_its_keys(page: Any) -> None:
    page.evaluate("() => { kinolab.pause(); kinolab.drive.start(); }")
    slider = page.locator(".sliders input").first
    slider.focus()
    before, time = slider.input_value(), page.evaluate("kinolab.drive.time")
    page.evaluate("kinolab.drive.pause()")
    page.keyboard.press("ArrowRight")
    assert float(slider.input_value()) == float(before) + 1
    page.evaluate("() => kinolab.drive.stop()")
    assert time >= 0


def test_dark_and_light_follow_the_system_and_the_switch(opened: Opener) -> None:
    dark, page = opened(color_scheme="dark"), opened(color_scheme="light")
    seen = picture(dark, "body")
    assert seen.mean() < 80
    assert seen.std() > 15  # something is to be seen
    assert picture(page, "body").mean() > 180
    page.keyboard.press("d")
    assert picture(page, "body").mean() < 80


def test_a_phone_shows_the_scene_and_a_drawer(opened: Opener) -> None:
    page = opened(viewport=PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert not page.locator("#panel").is_visible()
    seen = picture(page)
    assert seen.shape[1] == PHONE["width"]
    assert len(coin_pixels(seen)) > 20
    page.click("#drawer")
    assert page.locator("#panel").is_visible()
    assert page.locator("#stage").bounding_box()["height"] > 200
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_whatever_can_be_pressed_has_a_name(page: Any) -> None:
    names = page.eval_on_selector_all(
        "button, select, input, [role=img]",
        "all => all.map(e => e.getAttribute('aria-label') || e.innerText"
        " || (e.labels && e.labels[0] && e.labels[0].textContent) || '')",
    )
    assert len(names) > 20
    assert all(re.search(r"\S", name) for name in names)


def test_a_problem_is_shown_before_planning(opened: Opener, rolled: Solved, tmp_path: Path) -> None:
    page = opened(kinolab.save_page(rolled.problem, None, tmp_path / "before.html"))
    assert page.inner_text("#badge") == "Not planned yet"
    assert not page.locator("#transport").is_visible()
    frame = np.array(page.evaluate("kinolab.frames().coin"))
    expected = rolled.problem.frames(rolled.problem.start).reshape(3, 4)
    assert np.abs(frame[:3] - expected).max() < NEAR
