"""In a real browser, with the network refused: from an empty world to a verified plan."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.show.view.browsing import OWN, needs_chromium, until

pytest.importorskip("playwright")
pytest.importorskip("viser")

import kinolab
from kinolab.studio.opening import opened

pytestmark = needs_chromium
PATIENCE = 600_000.0  # [ms] for what may have to be compiled first
SIZES = {"1440": (1440, 900), "1024": (1024, 768)}
CALLS = """
window.calls = 0; window.frames = 0;
for (const kind of [WebGLRenderingContext, WebGL2RenderingContext])
  for (const name of ['drawArrays', 'drawElements', 'drawArraysInstanced', 'drawElementsInstanced'])
    if (kind.prototype[name]) {
      const draw = kind.prototype[name];
      kind.prototype[name] = function (...given)
        { window.calls++; return draw.apply(this, given); };
    }
"""
FRAMES = """
async (seconds) => {  // the page draws when its camera moves
  const shown = [...document.querySelectorAll('canvas')].find((canvas) => canvas.width > 100);
  const begun = performance.now(), calls = window.calls;
  let frames = 0;
  while (performance.now() - begun < 1000 * seconds) {
    const deltaY = frames % 2 ? 3 : -3;
    shown.dispatchEvent(new WheelEvent('wheel', {deltaY, bubbles: true, clientX: 9, clientY: 9}));
    await new Promise(requestAnimationFrame);
    frames++;
  }
  return [frames / seconds, (window.calls - calls) / frames];
}
"""

Opener = Callable[..., Any]


@pytest.fixture
def studio(browser: Any, tmp_path: Path) -> Iterator[Opener]:
    """Open the studio in a browser that reaches nothing else, and find nothing wrong in the end."""
    asked, said, open_ = list[str](), list[str](), []

    def open_page(scenario: str | None = None, size: tuple[int, int] = SIZES["1440"]) -> Any:
        served = opened(scenario, tmp_path)
        address = served.__enter__()
        width, height = size
        context = browser.new_context(viewport={"width": width, "height": height})
        open_.append((served, context))
        page = context.new_page()
        own = (address.rpartition("/")[0].rpartition("/")[0], *OWN)

        def guard(route: Any) -> None:
            if route.request.url.startswith(own):
                route.continue_()
            else:
                asked.append(route.request.url)
                route.abort()

        page.route("**/*", guard)
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("console", lambda m: said.append(m.text) if m.type == "error" else None)
        page.add_init_script(CALLS)
        page.goto(address)
        return page

    yield open_page
    for served, context in reversed(open_):
        context.close()
        served.__exit__(None, None, None)
    assert asked == []
    assert said == []


def tab(page: Any, name: str) -> None:
    page.get_by_role("tab", name=name).click()


def press(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def see(page: Any, words: str, patience: float = PATIENCE) -> None:
    page.get_by_text(re.compile(words)).first.wait_for(timeout=patience)


def type_in(page: Any, label: str, values: list[float]) -> None:
    """Type numbers into the inputs of a row, each again while an answer to the last replaces it."""
    row = page.get_by_text(label, exact=True).locator("xpath=ancestor::*[.//input][1]")
    for k, value in enumerate(values):
        box = row.locator("input:visible").nth(k)
        for _ in range(5):
            box.click()
            box.press("Control+A")
            box.type(f"{value:g}")
            box.press("Tab")
            page.wait_for_timeout(1000)
            if float(box.input_value()) == value:
                break


@pytest.mark.parametrize("width", SIZES)
def test_an_empty_world_becomes_a_verified_plan_around_three_obstacles(
    studio: Opener, tmp_path: Path, width: str
) -> None:
    page = studio(None, SIZES[width])
    see(page, "Start and goal are possible")
    places = {"Box": [1.5, 1.0, 0.25], "Ball": [2.5, 2.0, 0.25], "Cylinder": [3.5, 2.8, 0.25]}
    for kind, place in places.items():
        press(page, kind)
        see(page, f"undo: add a {kind.lower()}")
        type_in(page, "Position [m]", place)
        see(page, "undo: change the position")
    tab(page, "Pose")
    type_in(page, "psi [rad]", [0.5])
    see(page, "undo: start: psi")
    tab(page, "Plan")
    press(page, "Search")
    see(page, r"\d+ of \d+ checks passed")
    press(page, "Play")
    see(page, "^Pause$")
    page.keyboard.press("Control+S")
    tab(page, "File")
    see(page, ": saved$")
    written = tomllib.loads((tmp_path / "world.toml").read_text(encoding="utf-8"))
    there = {entry["name"]: entry["position"] for entry in written["world"]["obstacle"]}
    assert there == {f"{kind.lower()} 1": place for kind, place in places.items()}
    assert written["start"]["psi"] == 0.5
    problem = kinolab.load(tmp_path / "world.toml")
    problem.check_endpoints()
    assert len(problem.world.obstacles) == 3


def test_two_clicks_on_the_ground_make_a_wall_and_a_click_chooses_it_again(
    studio: Opener, tmp_path: Path
) -> None:
    page = studio()
    see(page, "Start and goal are possible")
    page.wait_for_timeout(5000)  # until the camera stands where it will
    press(page, "Wall by two clicks")
    see(page, "Click two points")
    for x, y in ((420, 420), (560, 420)):
        page.mouse.click(x, y)
        page.wait_for_timeout(1500)
    see(page, "undo: add a wall")
    see(page, "Edges along x, y and z")
    page.get_by_text("Which").locator("xpath=ancestor::*[.//input][1]").locator(
        "input"
    ).first.click()
    page.get_by_role("option", name="(none)").click()
    page.get_by_text("Edges along x, y and z").wait_for(state="hidden")
    page.wait_for_timeout(1000)
    page.mouse.click(490, 415)
    see(page, "Edges along x, y and z")
    press(page, "Save")
    see(page, "^Saved$")
    (wall,) = tomllib.loads((tmp_path / "world.toml").read_text(encoding="utf-8"))["world"][
        "obstacle"
    ]
    length, thickness, height = wall["box"]
    assert length > 0.3
    assert (thickness, height) == (0.1, 0.5)
    assert all(abs(end) < 5.0 for end in wall["position"])


def test_limits_of_an_input_are_written_into_the_scenario(studio: Opener, tmp_path: Path) -> None:
    page = studio()
    see(page, "Start and goal are possible")
    tab(page, "Choose")
    page.get_by_text("Limits", exact=True).click()
    type_in(page, "left", [-0.5, 0.4])
    see(page, "undo: change bounds of left")
    press(page, "Save")
    see(page, "^Saved$")
    written = tomllib.loads((tmp_path / "world.toml").read_text(encoding="utf-8"))
    assert written["bounds"] == {"left": [-0.5, 0.4]}


def test_a_start_in_collision_names_the_pair_and_undo_mends_it(studio: Opener) -> None:
    page = studio()
    see(page, "Start and goal are possible")
    press(page, "Box")
    type_in(page, "Position [m]", [-0.5])
    see(page, "undo: change the position")
    box = page.get_by_text("Position [m]").locator("xpath=ancestor::*[.//input][1]")
    assert box.locator("input:visible").first.input_value() == "-0.5"
    type_in(page, "Position [m]", [0.5, 0.5, 0.25])
    see(page, "robot touches box 1")
    press(page, "Undo")
    see(page, "undo: add a box")
    see(page, "Start and goal are possible")


def test_a_text_with_mistakes_leaves_the_last_good_scene(studio: Opener) -> None:
    page = studio()
    see(page, "Start and goal are possible")
    tab(page, "File")
    page.get_by_text("The text").click()
    text = page.locator("textarea").first
    wrong = text.input_value().replace('name = "diff_drive"', 'name = "dif_drive"')
    text.fill(wrong.replace("tolerance = 0.1", "tolerance = -1"))
    press(page, "Take over this text")
    see(page, "Did you mean 'diff_drive'")
    see(page, "last good scene is shown")
    see(page, "tolerance")


def fill_code(page: Any, text: str) -> None:
    """Type a machine into the editor, and take it over."""
    area = page.locator("textarea:visible").first
    area.fill(text)
    page.wait_for_timeout(1000)  # in which what was typed is sent
    press(page, "Take over (Ctrl-Enter)")


def test_a_machine_is_changed_beside_the_scene_and_its_mistake_is_shown_where_it_is(
    studio: Opener, tmp_path: Path
) -> None:
    page = studio(None, SIZES["1024"])
    see(page, "Start and goal are possible")
    tab(page, "Machine")
    press(page, "Edit a copy of this machine")
    see(page, "it runs as you")
    page.locator("textarea:visible").wait_for()
    text = page.locator("textarea:visible").first.input_value()
    assert (tmp_path / "diff_drive.py").read_text(encoding="utf-8") == text
    line = next(k for k, told in enumerate(text.splitlines(), 1) if "I_w, c_w =" in told)
    fill_code(page, text.replace("I_w, c_w =", "I_w, c_v ="))
    see(page, "last good scene is shown")
    see(page, r"failed on line \d+ \(NameError")
    see(page, "The last machine without a mistake is shown")
    red = page.locator("pre.kl-lines b").first
    red.wait_for()
    assert int(red.text_content()) > line  # where the name is used that is not there any more
    press(page, "Back to what worked")
    see(page, "Start and goal are possible")
    assert (tmp_path / "diff_drive.py").read_text(encoding="utf-8") == text
    press(page, "Equations and laws")
    see(page, "laws of mechanics hold")
    tab(page, "Equations")
    see(page, "∂L/∂q")


def test_a_plan_is_tried_compared_and_driven(studio: Opener) -> None:
    page = studio()
    see(page, "Start and goal are possible")
    tab(page, "Plan")
    press(page, "Search")
    see(page, r"\d+ of \d+ checks passed")
    page.get_by_text("Compare", exact=True).click()
    press(page, "Keep this plan to compare")
    see(page, r"kept \(orange\)")
    see(page, r"now \(blue\)")
    page.get_by_text("Try the plan").click()
    press(page, "Execute it")
    see(page, r"\d+ of 100 runs reached the goal")
    page.get_by_text("Drive it yourself").click()
    press(page, "Make the page")
    see(page, "Open the page")
    with page.context.expect_page() as opened_page:
        page.get_by_text("Open the page").click()
    driven = opened_page.value
    until(driven, "Boolean(window.kinolab?.ready)", 60.0)
    driven.keyboard.press("m")
    until(driven, "Boolean(window.kinolab.drive?.state)", 60.0)
    driven.close()


def test_a_world_of_ninety_thousand_triangles_takes_few_drawing_calls(
    studio: Opener, tmp_path: Path
) -> None:
    import trimesh

    hills = [trimesh.creation.icosphere(5, 0.4) for _ in range(5)]
    for k, hill in enumerate(hills):
        hill.apply_translation([0.8 + 0.9 * k, 2.0, 0.0])
    whole = trimesh.util.concatenate(hills)
    assert len(whole.faces) > 90_000
    whole.export(tmp_path / "hills.stl")
    boxes = "\n".join(
        "[[world.obstacle]]\nbox = [0.1, 0.1, 0.1]\n"
        f"position = [{0.2 * (k % 20)}, {3 + k // 20}, 1.0]"
        for k in range(99)
    )
    text = f"""schema = 1
title = "hills"
[system]
name = "diff_drive"
[world]
bounds = {{ x = [0, 5], y = [0, 5] }}
ground = "plane"
[[world.obstacle]]
mesh = "hills.stl"
{boxes}
[start]
x = 0.5
y = 0.5
[goal]
x = 4.5
y = 0.5
"""
    (tmp_path / "hills.toml").write_text(text)
    page = studio(str(tmp_path / "hills.toml"))
    see(page, "Start and goal are possible")
    page.wait_for_timeout(8000)
    _, calls = page.evaluate(FRAMES, 5.0)  # frames a second are for a quiet computer to tell
    assert 0 < calls < 300
