"""Commands that are killed, ended or interrupted at random moments."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path

from .sandbox import session
from .workshop import IMPROVED, PLAN, SCENARIO, Kind, Verdict, Workshop

NEAR = ("--set", "goal.x=2", "--set", "goal.y=1.5", "--set", "goal.tolerance=0.5")  # for OMPL
OMPL = (SCENARIO, "--planner", "rrt", *NEAR, "--no-optimize", "--no-animation")
STUDY = """
schema = 1
title = "Few runs"
seeds = 2
[limits]
iterations = 500
cpu = 60.0
[[case]]
scenarios = ["rolling_disk_maze"]
planners = ["rrt_fast"]
"""
# Commands by name: words, and whether they work on a run that is there.
COMMANDS: dict[str, tuple[tuple[str, ...], bool]] = {
    "plan": (PLAN, False),
    "plan, improved": (IMPROVED, False),
    "plan with pictures": ((SCENARIO, "--no-optimize"), False),
    "plan --jobs 2, threads": ((*PLAN, "--jobs", "2"), False),
    "plan --jobs 2, processes": ((*OMPL, "--jobs", "2"), False),
    "plan check": (("check",), True),
    "plan plot": (("plot",), True),
    "plan video": (("video", "--size", "64x64", "--fps", "2"), True),
    "plan execute": (("execute", "--runs", "20"), True),
    "plan view": (("view", "--no-browser"), True),
    "plan bench": (("bench", "study.toml", "--resume", "--jobs", "2"), False),
}
FRESH = ("plan", "plan, improved", "plan check", "plan execute")
WRITERS = ("plan", "plan execute", "plan check", "plan bench")
LATE = 0.7  # of a command's duration: about when it begins to write
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
CTRL_C = 3.0  # [s] until a command has ended after Ctrl-C; 1 is promised on an idle machine


def words_of(name: str, folder: Path, seed: int = 1) -> Sequence[str | Path]:
    """Return the arguments of a command."""
    words, on_run = COMMANDS[name]
    if on_run:
        return [words[0], folder, *words[1:]]
    seeded = () if name == "plan bench" else ("--seed", str(seed))
    return [*words, *seeded, "--out", folder]


def place_for(shop: Workshop, name: str, label: str) -> Path:
    """Return the folder that a command gets: one of a run, or none."""
    if name == "plan bench":
        (shop.place / "study.toml").write_text(STUDY)
    return shop.copy(label) if COMMANDS[name][1] else shop.empty(label)


@cache
def _duration(place: Path, name: str, fresh: bool) -> float:
    """Return how long a command takes, the shorter of two times, in [s]."""
    shop = Workshop(place)
    found = []
    for _ in range(2):
        folder = place_for(shop, name, "timed")
        ended = shop.run(*words_of(name, folder), fresh=fresh)
        if ended.code:
            raise SystemExit(f"{name}: {ended.err}")
        found.append(ended.seconds)
    return min(found)


def killed(
    shop: Workshop,
    rng: random.Random,
    names: Sequence[str] = tuple(COMMANDS),
    since: float = 0.0,
    fresh: bool = False,
) -> Verdict:
    """End a command at a moment of its duration, then do it again in the same folder."""
    name = rng.choice(names)
    number, whole = rng.choice(SIGNALS), rng.random() < 0.3
    whole_time = _duration(shop.place, name, fresh)
    after = rng.uniform(since * whole_time, whole_time)
    verdict = Verdict(f"{signal.Signals(number).name} {after:.3f} s into {name}")
    folder = place_for(shop, name, "killed")
    if not COMMANDS[name][1] and rng.random() < 0.5 and name != "plan bench":
        folder = shop.copy("killed")  # over a run that was there
    command = shop.start(*words_of(name, folder), fresh=fresh)
    time.sleep(after)
    struck = time.monotonic()
    (command.send_all if whole or number == signal.SIGINT else command.send)(number)
    ended = command.ended(60.0)
    verdict.seconds = ended.seconds
    begun_late = struck - command.begun > ended.seconds
    codes = [0, 130] if number == signal.SIGINT else [0, -number]
    verdict.heard(ended, codes)
    if number == signal.SIGINT and not begun_late:
        overdue = command.begun + ended.seconds - struck > CTRL_C
        verdict.late += overdue
    # Ctrl-C clears up; what other signals end does not, and the next run does.
    verdict.files(folder, settled=number == signal.SIGINT)
    _again(shop, verdict, name, folder)
    return verdict


def _again(shop: Workshop, verdict: Verdict, name: str, folder: Path) -> None:
    """Do the command once more where it was ended, and compare."""
    if COMMANDS[name][1] and not folder.is_dir():
        verdict.wrong.append("the run is gone")
        return
    ended = shop.run(*words_of(name, folder))
    verdict.heard(ended, [0])
    verdict.files(folder, settled=True)
    if name == "plan, improved":
        shop.compare(verdict, folder, 1, IMPROVED)
    elif name in ("plan", "plan with pictures", "plan check", "plan plot", "plan execute"):
        shop.compare(verdict, folder, 1)


def killed_fresh(shop: Workshop, rng: random.Random) -> Verdict:
    """End a command that is an interpreter of its own, which also imports."""
    return killed(shop, rng, FRESH, fresh=True)


def killed_late(shop: Workshop, rng: random.Random) -> Verdict:
    """End a command that writes rows or files, in the last part of its duration."""
    return killed(shop, rng, WRITERS, LATE)


JOBS = {
    "threads": (
        SCENARIO,
        "--no-animation",
        "--planner",
        "rrt_fast",
        "--set",
        "goal.tolerance=1e-9",
    ),
    "processes": (SCENARIO, "--no-animation", "--planner", "rrt", "--set", "goal.tolerance=1e-9"),
}


def orphans(shop: Workshop, rng: random.Random) -> Verdict:
    """End one process of several that search without an end, and expect none to be left over."""
    kind, jobs = rng.choice(tuple(JOBS)), rng.randint(2, 4)
    number, victim = rng.choice((*SIGNALS, signal.SIGQUIT)), rng.choice(("first", "second", "all"))
    if kind == "processes" and rng.random() < 0.3:
        number, victim = signal.SIGKILL, "one that searches"
    after = rng.uniform(0.0, 4.0 if kind == "processes" else 1.0)
    verdict = Verdict(f"{number.name} of {victim} {after:.3f} s into {jobs} {kind}")
    folder = shop.empty("orphans")
    words = ("--jobs", str(jobs), "--time-limit", "3", "--no-diagnosis", "--out", str(folder))
    command = shop.start(*JOBS[kind], *words)
    time.sleep(after)
    others = sorted(set(session(command.pid)) - {command.pid})
    if victim == "first" or not others:
        command.send(number)
    elif victim == "all":
        command.send_all(number)
    else:
        target = others[0] if victim == "second" else rng.choice(others[1:] or others)
        with suppress(ProcessLookupError):
            os.kill(target, number)
    ended = command.ended(60.0)
    verdict.seconds = ended.seconds
    codes = [0, 3, 4, 6, 130, *(-number for number in (*SIGNALS, signal.SIGQUIT))]
    verdict.heard(ended, codes, 30.0)
    verdict.files(folder, settled=False)
    return verdict


KINDS = (
    Kind("killed while forked", 500, killed),
    Kind("killed while starting", 200, killed_fresh),
    Kind("killed late", 200, killed_late),
    Kind("ends of --jobs", 200, orphans),
)
