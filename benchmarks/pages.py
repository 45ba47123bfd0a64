"""What interactive pages weigh, what writing them costs, and how fast they are drawn in software.

    python benchmarks/pages.py [RUN ...] [--triangles 100000] [--seconds 6]

RUN are folders of finished runs; left out, every built-in scenario is planned first, without being
improved. Seconds of writing are those of the processor. Pictures per second are those of Chromium
(found on the PATH) without a graphics processor, in the view that opens and in the one that follows
the machine, in a world with as many triangles as were asked for; there, what else runs on the
computer counts. *ms* is the time of all of Chromium's processes per picture, where it hardly does.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import trimesh

import kinolab
from kinolab.analyze.simulate import simulate
from kinolab.problem import PlanningTask
from kinolab.runs import MODEL, PAGE, read_run
from kinolab.scenario import builtin_scenarios
from kinolab.show.film.animation import animate
from kinolab.show.view import content_of, save_page, views
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from kinolab.world.obstacles.obstacle import Obstacle

FLAGS = (
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--no-first-run", "--disable-quic"),
)
WINDOW = {"width": 1280, "height": 800}
HEADINGS = ("scenario", "page, MB", "glb, MB", "GIF, s", "page and glb, s", "together, s")
TICK = os.sysconf("SC_CLK_TCK")


def measured(name: str, problem: PlanningTask, trajectory: Trajectory) -> tuple[str, ...]:
    """Return a row of the table; everything is compiled when the clock begins."""
    with tempfile.TemporaryDirectory() as scratch:
        folder, facts = Path(scratch), {"scenario": name, "status": "solved"}
        begun = time.process_time()
        animate(problem, trajectory)
        drawn = time.process_time()
        content = content_of(problem, trajectory, facts)
        for file, written in views(content).items():
            (folder / file).write_bytes(written)
        ended = time.process_time()
        sizes = [(folder / file).stat().st_size / 1e6 for file in (PAGE, MODEL)]
    seconds = (drawn - begun, ended - drawn, ended - begun)
    return (name, *(f"{value:.2f}" for value in (*sizes, *seconds)))


def motions(folders: Sequence[Path]) -> Iterator[tuple[str, PlanningTask, Trajectory]]:
    """Yield name, problem and motion of finished runs, or of all scenarios planned anew."""
    for folder in folders:
        run = read_run(folder)
        yield run.report["scenario"], run.problem, run.trajectory
    for name in () if folders else builtin_scenarios():
        problem = kinolab.load(name)
        trajectory = problem.solve(seed=1, optimize=False).trajectory
        if trajectory is None:
            print(f"{name}: nothing was found")
        else:
            yield name, problem, trajectory


def crowded(triangles: int) -> PlanningTask:
    """Return the coin's maze with balls above it, of as many triangles in all."""
    problem = kinolab.load("rolling_disk_maze")
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.4)
    balls = []
    for k in range(round(triangles / len(ball.faces))):
        place = [0.8 + 0.9 * (k % 10), 0.8 + 0.9 * (k // 10), 2.0]
        balls.append(Obstacle(f"ball {k}", ball.vertices + place, ball.faces))
    world = replace(problem.world, obstacles=(*problem.world.obstacles, *balls))
    return replace(problem, world=world)


def pictures(triangles: int, seconds: float) -> Iterator[str]:
    """Yield how many pictures per second a page with many triangles makes, by view."""
    from playwright.sync_api import sync_playwright

    problem = crowded(triangles)
    overrides = ["start.phi_dot=2.0", "start.psi_dot=0.3"]
    moved = simulate(kinolab.load("rolling_disk_maze", overrides=overrides), 3.0)
    plan = PlanResult("simulated", moved, None, "none", 0, 0, 0.0)
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        path = save_page(problem, plan, Path(scratch) / PAGE)
        chromium = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=list(FLAGS))
        page = browser.new_page(viewport=WINDOW)
        page.goto(path.as_uri())
        page.evaluate("async () => { await kinolab.ready; }")
        count = sum(len(obstacle.faces) for obstacle in problem.world.obstacles)
        page.evaluate(
            "() => { window.n = 0; (function f() { n++; requestAnimationFrame(f); })(); }"
        )
        for view in ("perspective", "follow"):
            page.evaluate("view => kinolab.view(view)", view)
            page.wait_for_timeout(2000)
            yield f"{count} triangles, {view}: {rate(page, seconds)}"
        browser.close()


def rate(page: Any, seconds: float) -> str:
    """Return pictures per second and milliseconds of the processor per picture."""
    made, spent, begun = page.evaluate("n"), children(), time.monotonic()
    page.wait_for_timeout(1000 * seconds)
    made, spent = page.evaluate("n") - made, children() - spent
    passed = time.monotonic() - begun
    return f"{made / passed:.1f} pictures per second, {1000 * spent / max(made, 1):.0f} ms each"


def children() -> float:
    """Return the processor's time in [s] of all processes below this one that are alive."""
    ticks: dict[int, tuple[int, int]] = {}
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        ticks[int(entry.parent.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    return sum(spent for pid, (_, spent) in ticks.items() if _descends(pid, ticks)) / TICK


def _descends(pid: int, ticks: dict[int, tuple[int, int]]) -> bool:
    parent = ticks[pid][0]
    return parent == os.getpid() or (parent in ticks and _descends(parent, ticks))


def main() -> None:
    """Print the table, then pictures per second."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="*", type=Path, metavar="RUN")
    parser.add_argument("--triangles", type=int, default=100_000)
    parser.add_argument("--seconds", type=float, default=6.0)
    given = parser.parse_args()
    print(f"| {' | '.join(HEADINGS)} |\n|{'---|' * len(HEADINGS)}")
    warm = kinolab.load("rolling_disk_maze")
    animate(warm, simulate(warm, 0.2))
    for name, problem, trajectory in motions(given.runs):
        print(f"| {' | '.join(measured(name, problem, trajectory))} |", flush=True)
    print()
    if shutil.which("chromium") is None:
        print("no pictures per second: there is no chromium")
        return
    for line in pictures(given.triangles, given.seconds):
        print(line, flush=True)


if __name__ == "__main__":
    main()
