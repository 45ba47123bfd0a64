"""Ten runs into one folder at once."""

from __future__ import annotations

import json
import random
import time
from pathlib import Path

from . import sandbox
from .workshop import IMPROVED, PLAN, SCENARIO, Kind, Verdict, Workshop

CROWD = 10
SEEDS = 5
PICTURES = ("scene.html", "result.glb", "animation.gif")
WITH_PICTURES = (SCENARIO, "--no-optimize")
ANOTHER = ("pendulum_swingup", "--no-optimize", "--no-animation")


def crowd(shop: Workshop, rng: random.Random) -> Verdict:
    """Let ten runs write into one folder, and expect it to be one of theirs."""
    words = [rng.choice((PLAN, PLAN, IMPROVED, ANOTHER)) for _ in range(CROWD)]
    for k in range(2 if rng.random() < 0.25 else 0):
        words[k] = WITH_PICTURES
    seeds = [rng.randint(1, SEEDS) for _ in range(CROWD)]
    wanted = [shop.done(seed, own) for seed, own in zip(seeds, words, strict=True)]
    verdict = Verdict(f"ten runs at once with seeds {seeds}")
    folder = shop.empty("crowd")
    commands = []
    for k in range(CROWD):
        arguments = [*words[k], "--seed", str(seeds[k]), "--out", folder]
        commands.append(sandbox.start(arguments, shop.place, shop.place / f"scratch{k}"))
        time.sleep(rng.choice((0.0, 0.0, 0.05)))
    for command in commands:
        ended = command.ended(300.0)
        verdict.heard(ended, (0,), 300.0)
        verdict.seconds = max(verdict.seconds, ended.seconds)
    verdict.files(folder, settled=True)
    verdict.heard(shop.run("check", folder), [0])
    report = json.loads((folder / "report.json").read_text())
    one = [k for k in range(CROWD) if _same(folder, wanted[k], "trajectory.csv")]
    if not any(seeds[k] == report["seed"] for k in one):
        verdict.wrong.append("report and motion are of different runs")
    for name in ("trajectory.npz", "assets/machine.json", "search.npz"):
        if not any(_same(folder, wanted[k], name) for k in one):
            verdict.wrong.append(f"{name} is of another run")
    if (folder / "result.glb").exists() and not any(
        _same(folder, wanted[k], "result.glb") for k in one
    ):
        verdict.wrong.append("result.glb is of another run")
    return verdict


def _same(folder: Path, other: Path, name: str) -> bool:
    paths = [one / name for one in (folder, other)]
    if not all(path.exists() for path in paths):
        return not any(path.exists() for path in paths)
    return paths[0].read_bytes() == paths[1].read_bytes()


KINDS = (Kind("ten at once", 40, crowd),)
