"""The studio in Chromium without a graphics processor: do gallery scenarios open, plan and play?

    python benchmarks/studio.py [SCENARIO ...] [--seconds 300] [--triangles 90000]

SCENARIO are built-in ones; left out, all. Each is opened, searched for as its file says, and played
to its end; one row says how far it came. Then a world of triangles is looked at, with pictures per
second and drawing calls for each of them; there, what else runs on the computer counts.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import trimesh

from kinolab.scenario import builtin_scenarios
from kinolab.studio.opening import opened

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.show.view.browsing import CHROMIUM, FLAGS
from tests.studio.test_studio_page import CALLS, FRAMES, press, tab

WORLD = """schema = 1
title = "a ball of many triangles"
[system]
name = "diff_drive"
[world]
bounds = { x = [0, 5], y = [0, 5] }
ground = "plane"
[[world.obstacle]]
mesh = "ball.stl"
position = [2.5, 2.5, 0.0]
[start]
x = 0.5
y = 0.5
[goal]
x = 4.5
y = 0.5
"""


@contextmanager
def shown(browser: Any, scenario: str, folder: Path) -> Iterator[Any]:
    """Open a scenario in the studio; yield its page."""
    with opened(scenario, folder) as address:
        context = browser.new_context(viewport={"width": 1440, "height": 900})
        page = context.new_page()
        page.add_init_script(CALLS)
        page.goto(address)
        yield page
        context.close()


def row(page: Any, patience: float) -> tuple[str, str, str]:
    """Return whether a scenario that is open can be planned for, what came of it, and its play."""
    see = page.get_by_text
    see("Start and goal are possible").first.wait_for(timeout=patience)
    tab(page, "Plan")
    press(page, "Search")
    ended = re.compile(r"^(solved|approximate|not_found|local_minimum|interrupted):")
    see(ended).first.wait_for(timeout=patience)
    found = see(ended).first.text_content().partition(":")[0]
    if found != "solved":
        return "yes", found, ""
    press(page, "Play")
    page.get_by_role("button", name="Play", exact=True).wait_for(timeout=patience)
    return "yes", found, "yes"


def main() -> None:
    """Print the tables."""
    from playwright.sync_api import Error, sync_playwright

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenarios", nargs="*")
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--triangles", type=int, default=90_000)
    given = parser.parse_args()
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        print("| scenario | opens | search | plays |\n|---|---|---|---|")
        for name in given.scenarios or builtin_scenarios():
            with shown(browser, name, Path(scratch)) as page:
                try:
                    told = row(page, 1000.0 * given.seconds)
                except Error as error:
                    told = ("", str(error).partition("\n")[0], "")
            print(f"| {name} | {' | '.join(told)} |", flush=True)
        ball = trimesh.creation.icosphere(6, 1.0)  # 81 920 triangles
        while len(ball.faces) < given.triangles:
            ball = trimesh.util.concatenate([ball, trimesh.creation.icosphere(5, 1.2)])
        ball.export(Path(scratch) / "ball.stl")
        (Path(scratch) / "ball.toml").write_text(WORLD)
        with shown(browser, str(Path(scratch) / "ball.toml"), Path(scratch)) as page:
            page.get_by_text("Start and goal are possible").first.wait_for(timeout=60_000.0)
            page.wait_for_timeout(8000)  # [ms] until everything is there
            pictures, calls = page.evaluate(FRAMES, 5.0)
        print(f"\n{len(ball.faces)} triangles: {pictures:.1f} pictures/s, {calls:.0f} calls each")
        browser.close()


if __name__ == "__main__":
    main()
