"""Worlds that nobody here wrote: how long they take, and how short their plans become.

    python benchmarks/worlds.py RESOURCES [WORLD ...] [--long 30] [--scan 460] [--seed 1]

RESOURCES is the folder ``resources`` of OMPL.app (github.com/ompl/omplapp); its files are read as
they are, turned as OMPL.app's own reader turns them; Barriers is scaled to the car. The car drives
in the planar worlds, a ball that is pushed flies in the others. ``--scan N`` adds a scan of N x N
points. For each world one row: triangles, seconds to load, search and verify, the
motion that was found, what the default improvement makes of it, and what ``--long`` seconds of work
make of it.

It needs the extra ``collada``. Run it twice: the first time it compiles.
"""

from __future__ import annotations

import argparse
import configparser
import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import kinolab
from kinolab.dynamics import Body, Control, Sphere, System, Wrench, length, move, parameter
from kinolab.verification import verify
from kinolab.world import mesh_obstacle

CAR = ("Maze_planar", "BugTrap_planar", "RandomPolygons_planar", "UniqueSolutionMaze", "Barriers")
# Scale, and where the car points beside its own robot: that one is 66 m long, along y.
OTHERWISE = {"Barriers": (0.08, math.pi / 2.0)}
# The radius of the ball in [m], about half the least extent of OMPL.app's own robot.
BALL = {
    "Home": 12.0,
    "cubicles": 10.0,
    "Abstract": 9.0,
    "Apartment": 6.0,
    "Easy": 20.0,
    "Twistycool": 20.0,
}
HEADINGS = (
    *("world", "triangles", "load, s", "search, s", "verify, s", "verify / search"),
    *("found, s", "improved, s", "long run, s", "improved / long"),
)
TIME_LIMIT = 120.0  # [s] of a search


@dataclass(frozen=True)
class Row:
    """What one world takes; seconds, and seconds of motion."""

    world: str
    triangles: int
    load: float
    search: float
    verify: float
    found: float
    improved: float
    long: float
    status: str

    def cells(self) -> Iterator[str]:
        """Yield the cells of a table's row."""
        yield from (self.world, str(self.triangles), f"{self.load:.1f}")
        if not math.isfinite(self.found):
            yield from (self.status, *["–"] * 6)
            return
        yield from (f"{self.search:.2f}", f"{self.verify:.2f}", f"{self.verify / self.search:.1f}")
        yield from (f"{self.found:.1f}", f"{self.improved:.1f}", f"{self.long:.1f}")
        yield f"{self.improved / self.long:.2f}"


def ball(radius: float, speed: float) -> System:
    """A ball in space, without weight, pushed along three axes."""
    m = parameter("m", 1.0, "kg")
    x, y, z = (length(name, speed=speed) for name in "xyz")
    hull = Body("ball", move(x, y, z), mass=m, shape=Sphere(radius))
    pushes = [Control(f"f{name}", limit=speed / 2.0) for name in "xyz"]
    force = tuple(push.symbol * m for push in pushes)
    return System("ball", bodies=[hull], inputs=pushes, efforts=[Wrench(on=hull, force=force)])


def planar(resources: Path, name: str) -> dict[str, Any]:
    """Return the scenario of a car in a planar world."""
    folder = resources / "2D"
    given = problem_in(folder / f"{name}.cfg")
    scale, turn = OTHERWISE.get(name, (1.0, 0.0))
    bounds = {
        axis: [scale * given[f"volume.{end}.{axis}"] for end in ("min", "max")] for axis in "xy"
    }
    ends = {
        end: {axis: scale * given[f"{end}.{axis}"] for axis in "xy"} for end in ("start", "goal")
    }
    mesh = {**mesh_of(folder, given["world"]), "scale": scale}
    return {
        "system": {"name": "car"},
        "world": {
            "bounds": bounds,
            "ground": "plane",
            "obstacle": [raised(folder, mesh)],
        },
        "bounds": {"phi_dot": [-10.0, 10.0]},
        "metric": {"phi": 1e-4, "psi": 2.0},
        "start": {**ends["start"], "psi": turn + given.get("start.theta", 0.0)},
        "goal": {**ends["goal"], "tolerance": 1.0},
        "integration": {"step": 0.1},
    }


def spatial(resources: Path, name: str) -> dict[str, Any]:
    """Return the scenario of a ball in a world in space."""
    folder = resources / "3D"
    given = problem_in(folder / f"{name}.cfg")
    bounds = {axis: [given[f"volume.min.{axis}"], given[f"volume.max.{axis}"]] for axis in "xyz"}
    speed = max(high - low for low, high in bounds.values()) / 30.0
    ends = {end: {axis: given[f"{end}.{axis}"] for axis in "xyz"} for end in ("start", "goal")}
    return {
        "system": ball(BALL[name], speed),
        "world": {"bounds": bounds, "obstacle": [mesh_of(folder, given["world"])]},
        "start": ends["start"],
        "goal": {**ends["goal"], "tolerance": BALL[name] / 2.0},
        "integration": {"step": 0.1},
    }


def mesh_of(folder: Path, file: str) -> dict[str, Any]:
    """Return the obstacle of a file; Assimp, which OMPL.app reads by, turns z to y."""
    return {"mesh": file, "rpy": [-math.pi / 2.0, 0.0, 0.0], "root": folder}


def raised(folder: Path, entry: dict[str, Any]) -> dict[str, Any]:
    """Return the obstacle, on the ground where its file has it below: Barriers hangs from z = 0."""
    placed = {key: entry[key] for key in ("rpy", "scale")}
    vertices = mesh_obstacle("world", entry["mesh"], folder, **placed).vertices
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    return entry if high > 1e-6 else {**entry, "position": [0.0, 0.0, -low]}


def problem_in(file: Path) -> dict[str, Any]:
    """Return the section [problem] of OMPL.app's file, numbers as numbers."""
    reader = configparser.ConfigParser(strict=False)
    reader.read(file)
    found: dict[str, Any] = {}
    for key, text in reader["problem"].items():
        try:
            found[key] = float(text)
        except ValueError:
            found[key] = text
    return found


def scan(points: int, folder: Path) -> dict[str, Any]:
    """Return a scenario of the ball above a noisy surface with towers, written to a folder."""
    import trimesh

    rng, size = np.random.default_rng(0), 60.0
    side = np.linspace(0.0, size, points)
    x, y = np.meshgrid(side, side, indexing="ij")
    z = 0.6 * np.sin(x / 5.0) * np.cos(y / 7.0) + 0.02 * rng.standard_normal(x.shape)
    for cx, cy, radius in rng.uniform((9.0, 9.0, 1.5), (51.0, 51.0, 4.0), (14, 3)):
        tower = np.hypot(x - cx, y - cy) < radius
        z = np.where(tower, 8.0 + 0.05 * rng.standard_normal(x.shape), z)
    index = np.arange(points * points).reshape(points, points)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    mesh = trimesh.Trimesh(np.stack([x, y, z], -1).reshape(-1, 3), faces, process=False)
    mesh.export(folder / "scan.ply")
    bounds = {"x": [0.0, size], "y": [0.0, size], "z": [0.0, 7.0]}
    return {
        "system": ball(0.4, 3.0),
        "world": {"bounds": bounds, "obstacle": [{"mesh": "scan.ply", "root": folder}]},
        "start": {"x": 2.0, "y": 2.0, "z": 1.6},
        "goal": {"x": 57.0, "y": 57.0, "z": 1.6, "tolerance": 0.5},
        "integration": {"step": 0.1},
    }


def measured(name: str, table: dict[str, Any], seed: int, long: float) -> Row:
    """Load, plan, verify and improve in one world."""
    (root,) = {entry.pop("root") for entry in table["world"]["obstacle"]}
    table |= {"schema": 1, "title": name, "planner": {"time_limit": TIME_LIMIT, "seed": seed}}
    begun = time.perf_counter()
    problem = loaded(table, root)
    took = time.perf_counter() - begun
    for warning in problem.world.warnings:
        print(f"{name}: {warning}", flush=True)
    triangles = sum(len(o.faces) for o in (*problem.world.obstacles, *problem.world.floors))
    raw = problem.solve(optimize=False)
    nothing = (math.nan,) * 5
    if raw.status != "solved" or raw.trajectory is None:
        return Row(name, triangles, took, *nothing, raw.status)
    begun = time.perf_counter()
    verify(problem, raw.trajectory)
    checked = time.perf_counter() - begun
    plan = problem.solve()
    best = problem.solve(improve=long)
    spent = raw.timings["search"]
    print(plan, flush=True)
    motions = (raw.trajectory.duration, plan.cost or math.nan, best.cost or math.nan)
    return Row(name, triangles, took, spent, checked, *motions, plan.status)


def loaded(table: dict[str, Any], root: Path) -> kinolab.Problem:
    """Build a problem whose meshes lie below a folder; tables look them up from where one is."""
    with chdir(root):
        return kinolab.load(table)


def main() -> None:
    """Measure and print a table in Markdown."""
    parser = argparse.ArgumentParser(description="Plan in worlds of OMPL.app and in a scan.")
    parser.add_argument("resources", type=Path)
    parser.add_argument("worlds", nargs="*", metavar="WORLD")
    parser.add_argument("--long", type=float, default=30.0, help="seconds of work of a long run")
    parser.add_argument("--scan", type=int, default=0, help="points along a side of a scan")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if unknown := set(options.worlds) - {*CAR, *BALL}:
        parser.error(f"no such world: {', '.join(unknown)}; there are {', '.join((*CAR, *BALL))}")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in options.worlds or (*CAR, *BALL):
            make = spatial if name in BALL else planar
            table = make(options.resources, name)
            rows.append(measured(name, table, options.seed, options.long))
            print(" | ".join(rows[-1].cells()), flush=True)
        if options.scan:
            table = scan(options.scan, Path(folder))
            rows.append(measured("scan", table, options.seed, options.long))
    print(f"\n| {' | '.join(HEADINGS)} |\n|{' --- |' * len(HEADINGS)}")
    for row in rows:
        print(f"| {' | '.join(row.cells())} |")


if __name__ == "__main__":
    main()
