"""Files that are broken in thousands of ways, each given to the command that reads it."""

from __future__ import annotations

import json
import random
import shutil
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from .plain_data import NUMBERS, TEXTS, any_value, inline, mutate, spoil, toml
from .workshop import SCENARIO, Kind, Verdict, Workshop, remove

LIMIT = 60.0  # [s] for a hostile file
GIGABYTES = 6.0
CODES = (0, 2, 3, 4, 5, 6, 7)  # all that are documented but for Ctrl-C and a mistake of kinolab's
SEARCH = (
    "--no-animation",
    "--no-diagnosis",
    "--no-optimize",
    "--max-iterations",
    "200",
    "--time-limit",
    "2",
)
CODE = (
    "",
    "def machine(:\n",
    "raise SystemExit(3)\n",
    "import os; os._exit\n",
    "1/0\n",
    "import nonexistent\n",
    "def machine():\n    return None\n",
    "def machine():\n    raise ValueError('no')\n",
    "def machine():\n    return machine()\n",
    "def machine(x, y):\n    return 1\n",
    "machine = 3\n",
    "def machine():\n    raise SystemExit\n",
    "def machine():\n    raise BaseException('odd')\n",
    "\0",
    "é = 'ä'\n# -*- coding: nonsense -*-\n",
    "# -*- coding: nonsense -*-\n",
    "from kinolab import System\ndef machine():\n    return System\n",
    "import sys\nsys.stdout.close()\ndef machine():\n    return 1\n",
    "print('x' * 100000)\n",
    "def machine():\n    raise MemoryError\n",
    "def machine():\n    assert False\n",
    "class machine:\n    pass\n",
    "from kinolab.systems import rolling_disk as machine\n",
    "def machine():\n    raise Exception('a\\nb\\x1b[31m\\ud800')\n",
    "def machine():\n    yield 1\n",
    "import warnings\nwarnings.warn('x')\n",
    "raise StopIteration\n",
)
PARTS = (
    "trajectory.csv", "trajectory.npz", "report.json", "scenario.toml", "assets/machine.json",
    "search.npz", "assets/1_rolling_disk_maze.stl",
)  # fmt: skip
READERS = (
    ["check"], ["check"], ["check", "--json"], ["plot"], ["execute", "--runs", "2", "--no-picture"],
    ["view", "--no-browser"], ["gallery"], ["video", "--size", "16x16", "--fps", "1"],
)  # fmt: skip
STUDY = {
    "schema": 1,
    "title": "x",
    "seeds": 1,
    "limits": {"iterations": 20, "cpu": 5.0},
    "case": [
        {
            "scenarios": [SCENARIO],
            "planners": ["rrt_fast"],
            "sweep": {"planner.goal_bias": [0.1]},
        }
    ],
}
KEYS = (
    "goal.x", "goal.tolerance", "planner.name", "planner.time_limit", "start.psi", "world.bounds.x",
    "world.obstacle", "system.parameters.R", "integration.step", "integration.method", "metric.psi",
    "", "x", "a.b.c.d", "schema", "world.obstacle.0.box", "world.clearance", "bounds.drive",
    "planner.improve", "planner.seed", "title", "=",
)  # fmt: skip
OPTIONS = (
    (), (), ("--seed", "-1"), ("--jobs", "0"), ("--roadmap", "/"), ("--max-iterations", "x"),
    ("--nonsense",), *(("--planner", text.replace("\0", "")) for text in TEXTS),
)  # fmt: skip


@cache
def _scenarios() -> dict[str, dict[str, Any]]:
    """Return scenarios as plain data, paths of meshes made absolute."""
    import kinolab.scenarios

    folder = Path(kinolab.scenarios.__file__).parent.resolve()
    if not list(folder.glob("*.toml")):
        folder = Path(__file__).resolve().parents[2] / "scenarios"
    found = {}
    for path in sorted(folder.glob("*.toml")):
        tree = tomllib.loads(path.read_text())
        for entry in tree.get("world", {}).get("obstacle", []):
            if "mesh" in entry:
                entry["mesh"] = str(folder / entry["mesh"])
        found[path.stem] = tree
    return found


QUICK = (
    "rolling_disk_maze",
    "pendulum_swingup",
    "diffdrive_trap",
    "vehicle_parking",
    "unicycle_slalom",
    "satellite_pointing",
)


class Case:
    """A hostile file, and the command that reads it.

    Args:
        what: Of the file.
        words: Of the command.
        writes: The folder or file that must not be there if the command refuses.
    """

    def __init__(self, what: str, words: list[str | Path], writes: Path | None = None) -> None:
        self.what, self.words, self.writes = what, words, writes


def _scenario(shop: Workshop, rng: random.Random) -> Case:
    name = rng.choice(QUICK)
    tree = _scenarios()[name]
    path, out = shop.place / "hostile.toml", shop.empty("hostile")
    text = toml(mutate(tree, rng)) if rng.random() < 0.7 else None
    content = (
        spoil(toml(tree).encode(), rng) if text is None else text.encode(errors="surrogatepass")
    )
    path.write_bytes(content)
    return Case(f"scenario {name}", [path, *SEARCH, "--out", out], out)


def _machine(shop: Workshop, rng: random.Random) -> Case:
    own = rng.choice(QUICK[:4])
    source = _machine_of(shop, own)
    path = shop.place / "hostile.json"
    tree = json.loads(source)
    content = json.dumps(mutate(tree, rng)).encode() if rng.random() < 0.7 else spoil(source, rng)
    path.write_bytes(content)
    word = rng.choice(("describe", "equations", "examine"))
    return Case(f"machine of {own} for {word}", [word, path])


_machines: dict[str, bytes] = {}


def _machine_of(shop: Workshop, scenario: str) -> bytes:
    if scenario not in _machines:
        folder = shop.empty("machine")
        ended = shop.run(scenario, "--no-optimize", "--no-animation", "--no-diagnosis",
                         "--max-iterations", "200", "--out", folder)  # fmt: skip
        if not (folder / "assets/machine.json").exists():
            raise SystemExit(f"{scenario}: {ended.err}")
        _machines[scenario] = (folder / "assets/machine.json").read_bytes()
    return _machines[scenario]


def _code(shop: Workshop, rng: random.Random) -> Case:
    path = shop.place / "hostile.py"
    path.write_bytes(rng.choice(CODE).encode(errors="surrogatepass"))
    word = rng.choice(("describe", "equations", "examine", "scenario"))
    if word != "scenario":
        return Case("Python file of a machine", [word, f"{path}:machine"])
    own, out = shop.place / "hostile.toml", shop.empty("hostile")
    tree = dict(_scenarios()[SCENARIO])
    if rng.random() < 0.5:
        tree["system"] = {"file": f"{path}:machine"}
    else:
        tree["planner"] = {"name": f"{path}:machine"}
    own.write_text(toml(tree))
    return Case("Python file of a scenario", [own, *SEARCH, "--out", out], out)


@cache
def _meshes() -> dict[str, bytes]:
    """Return meshes by the name of a file, in all formats."""
    import trimesh

    found = {}
    for form in ("stl", "obj", "ply", "glb", "off", "stl_ascii"):
        box = trimesh.creation.icosphere(1, 0.5)
        content = box.export(file_type=form)
        found[f"mesh.{form.partition('_')[0]}" if form != "stl_ascii" else "ascii.stl"] = (
            content.encode() if isinstance(content, str) else content
        )
    return found


def _mesh(shop: Workshop, rng: random.Random) -> Case:
    name = rng.choice(tuple(_meshes()))
    path = shop.place / f"hostile-{name}"
    path.write_bytes(spoil(_meshes()[name], rng))
    tree = dict(_scenarios()[SCENARIO])
    further = rng.choice(
        ({}, {}, {"scale": rng.choice(NUMBERS)}, {"position": [rng.choice(NUMBERS)] * 3})
    )
    entry = {"mesh": str(path), "position": [5.0, 5.0, 0.5], **further}
    tree["world"] = {**tree["world"], "obstacle": [entry]}
    own, out = shop.place / "hostile.toml", shop.empty("hostile")
    own.write_text(toml(tree))
    return Case(f"mesh {name}", [own, *SEARCH, "--out", out], out)


def _run_folder(shop: Workshop, rng: random.Random) -> Case:
    folder, part = shop.copy("hostile-run"), rng.choice(PARTS)
    path = folder / part
    content = path.read_bytes()
    if path.suffix == ".json" and rng.random() < 0.7:
        content = json.dumps(mutate(json.loads(content), rng)).encode()
    elif path.suffix == ".toml" and rng.random() < 0.7:
        content = toml(mutate(tomllib.loads(content.decode()), rng)).encode(errors="surrogatepass")
    else:
        content = spoil(content, rng)
    path.write_bytes(content)
    reader = rng.choice(READERS)
    if reader[0] == "gallery":
        return Case(
            f"{part} for gallery", ["gallery", folder, "--out", shop.place / "gallery.html"]
        )
    return Case(f"{part} for {reader[0]}", [reader[0], folder, *reader[1:]])


def _roadmap(shop: Workshop, rng: random.Random) -> Case:
    kept, path, out = shop.place / "roadmap.npz", shop.place / "hostile.npz", shop.empty("hostile")
    if not kept.exists():
        ended = shop.run(SCENARIO, "--planner", "prm", *SEARCH, "--roadmap", kept, "--out", out)
        if not kept.exists():
            raise SystemExit(f"no roadmap: {ended.err}")
        remove(out)
    path.write_bytes(spoil(kept.read_bytes(), rng))
    words = [SCENARIO, "--planner", "prm", *SEARCH, "--roadmap", path, "--out", out]
    return Case("roadmap", words)


def _study(shop: Workshop, rng: random.Random) -> Case:
    path, out = shop.place / "hostile.toml", shop.empty("hostile")
    text = toml(mutate(STUDY, rng)).encode(errors="surrogatepass")
    path.write_bytes(text if rng.random() < 0.7 else spoil(toml(STUDY).encode(), rng))
    return Case("study", ["bench", path, "--out", out, "--jobs", "1", "--quiet"], out)


ENVIRONMENT = """
name: wall
environment:
  min: [0, 0]
  max: [10, 10]
  obstacles:
    - {type: box, center: [5, 5], size: [1, 1]}
robots:
  - {type: unicycle1_v0, start: [1, 1, 0], goal: [9, 9, 0]}
"""


def _environment(shop: Workshop, rng: random.Random) -> Case:
    import yaml

    path, out = shop.place / "hostile.yaml", shop.empty("hostile")
    tree = yaml.safe_load(ENVIRONMENT)
    if rng.random() < 0.6:
        content = yaml.safe_dump(mutate(tree, rng), allow_unicode=True).encode(
            errors="surrogatepass"
        )
    else:
        content = spoil(ENVIRONMENT.encode(), rng)
    bombs = (
        b"a: &a [x]\nb: &b [*a,*a]\nc: [*b,*b]\n",
        b"a: &a [*a]\n",
        b"!!python/object:os.system x\n",
        b"- " * 3000,
    )
    path.write_bytes(rng.choice(bombs) if rng.random() < 0.05 else content)
    return Case("environment", [path, *SEARCH, "--out", out], out)


def _arguments(shop: Workshop, rng: random.Random) -> Case:
    out, words = shop.empty("hostile"), []
    for _ in range(rng.randint(1, 3)):
        value = rng.choice(
            (str(rng.choice(NUMBERS)), rng.choice(TEXTS), inline(any_value(rng)), "pi/2", "90 deg")
        )
        value = value.replace("\0", "").encode(errors="replace").decode()
        words += ["--set", f"{rng.choice(KEYS)}{rng.choice(('=', '=', '', '=='))}{value}"]
    further = rng.choice(OPTIONS)
    return Case(
        f"arguments {words} {further}", [SCENARIO, *SEARCH, *words, *further, "--out", out], out
    )


def _inputs(shop: Workshop, rng: random.Random) -> Case:
    path = shop.place / "hostile.csv"
    content = (shop.done(1) / "trajectory.csv").read_bytes()[:3000]
    path.write_bytes(spoil(content[: content.rfind(b"\n") + 1], rng))
    return Case(
        "inputs of a simulation",
        ["simulate", SCENARIO, "--inputs", path, "--out", shop.place / "simulated"],
    )


MAKERS: dict[str, tuple[int, Callable[[Workshop, random.Random], Case]]] = {
    "scenarios": (1200, _scenario),
    "machines": (700, _machine),
    "Python files": (100, _code),
    "meshes": (600, _mesh),
    "runs": (1000, _run_folder),
    "roadmaps": (250, _roadmap),
    "studies": (250, _study),
    "environments": (250, _environment),
    "arguments": (400, _arguments),
    "inputs": (150, _inputs),
}


def _hostile(
    make: Callable[[Workshop, random.Random], Case],
) -> Callable[[Workshop, random.Random], Verdict]:
    def strike(shop: Workshop, rng: random.Random) -> Verdict:
        case = make(shop, rng)
        verdict = Verdict(f"hostile {case.what}")
        for name in ("gallery.html", "simulated"):
            remove(shop.place / name)
        ended = shop.run(*case.words, limit=LIMIT, gigabytes=GIGABYTES)
        verdict.seconds = ended.seconds
        verdict.heard(ended, CODES, LIMIT)
        if ended.code not in (0, 3, 4, 5, 7) and "rror: " not in ended.err:
            verdict.wrong.append(f"exit code {ended.code} without a word: {ended.err[-300:]}")
        if ended.code == 2 and case.writes is not None and case.writes.exists():
            left = [path for path in case.writes.rglob("*") if path.is_file()] or [case.writes]
            verdict.wrong.append(
                f"refused, yet it wrote {[str(path.name) for path in left][:5]}: {ended.err[-300:]}"
            )
        if case.writes is not None and case.writes.is_dir():
            verdict.files(case.writes, settled=True)
        if not verdict.sound:
            keep = (
                shop.place
                / "found"
                / f"{make.__name__.strip('_')}-{len(list(shop.place.glob('found/*')))}"
            )
            remove(keep)
            keep.mkdir(parents=True)
            (keep / "words").write_text("\n".join(map(str, case.words)))
            for path in shop.place.glob("hostile*"):
                if path.is_dir():
                    shutil.copytree(path, keep / path.name, symlinks=True)
                else:
                    shutil.copy2(path, keep / path.name)
        return verdict

    return strike


KINDS = tuple(
    Kind(f"hostile {name}", count, _hostile(make)) for name, (count, make) in MAKERS.items()
)
