"""Native code that crashes: in collision checks, in planners, in the processes of several jobs."""

from __future__ import annotations

import ctypes
import json
import os
import random
import signal
from collections.abc import Callable

from .kills import OMPL
from .workshop import PLAN, SCENARIO, Kind, Verdict, Workshop

PLANNER = '''
"""A planner that crashes with some seeds, as native code does."""

import ctypes
import os
import signal
from dataclasses import dataclass
from typing import ClassVar

from kinolab.planners.{module} import {parent}


@dataclass(frozen=True, kw_only=True)
class Crashing({parent}):
    """Crashes."""

    name: ClassVar[str] = "crashing"

    def solve(self, problem, seed, budget):
        if seed in {seeds}:
            {crash}
        return super().solve(problem, seed, budget)
'''
CRASHES = {
    "SIGSEGV": "ctypes.string_at(0)",
    "SIGABRT": "os.abort()",
    "SIGBUS": "os.kill(os.getpid(), signal.SIGBUS)",
    "SIGFPE": "os.kill(os.getpid(), signal.SIGFPE)",
    "SIGILL": "os.kill(os.getpid(), signal.SIGILL)",
}
PARENTS = {"threads": ("rrt_fast", "RRTFast"), "processes": ("rrt", "RRT")}


def planner(shop: Workshop, rng: random.Random) -> Verdict:
    """Let searches with some of several seeds crash: the others go on, each crash is reported."""
    kind, jobs = rng.choice(tuple(PARENTS)), rng.choice((1, 2, 3))
    seeds = sorted(rng.sample(range(1, jobs + 1), rng.randint(1, jobs)))
    crash = rng.choice(tuple(CRASHES))
    module, parent = PARENTS[kind]
    verdict = Verdict(f"{crash} with seeds {seeds} of {jobs}, planner for {kind}")
    text = PLANNER.format(module=module, parent=parent, seeds=seeds, crash=CRASHES[crash])
    (shop.place / "crashing.py").write_text(text)
    folder = shop.empty("crash")
    words = [SCENARIO, "--planner", "crashing.py:Crashing", "--no-optimize", "--no-animation"]
    ended = shop.run(*words, "--seed", "1", "--jobs", str(jobs), "--out", folder)
    verdict.seconds = ended.seconds
    verdict.heard(ended, [0, 70])
    verdict.files(folder, settled=True)
    if len(seeds) == jobs:  # nobody is left
        if ended.code != 70 or crash not in ended.err:
            verdict.wrong.append(
                f"exit code {ended.code} is not told as a crash: {ended.err[-400:]}"
            )
        return verdict
    if ended.code != 0:
        verdict.wrong.append(f"exit code {ended.code}, though others go on: {ended.err[-400:]}")
        return verdict
    report = json.loads((folder / "report.json").read_text())
    told = {attempt["seed"]: attempt for attempt in report["attempts"]}
    for seed in seeds:
        detail = told[seed]["detail"]
        if crash not in detail and "had won" not in detail:  # before it could crash
            verdict.wrong.append(f"seed {seed} is reported as {told[seed]}")
    verdict.heard(shop.run("check", folder), [0])
    return verdict


def collision(shop: Workshop, rng: random.Random) -> Verdict:
    """Let FCL crash in some call of a command."""
    words, own = rng.choice(((["check"], True), (list(OMPL), False), (list(PLAN), False)))
    crash, call = rng.choice(tuple(CRASHES)), rng.randint(1, 20)
    verdict = Verdict(f"{crash} in FCL's call {call} of {words}")
    folder = shop.copy("crash") if own else shop.empty("crash")
    arguments = [*words, folder] if own else [*words, "--seed", "1", "--out", folder]
    ended = shop.run(*arguments, prepare=_crashing(crash, call))
    verdict.seconds = ended.seconds
    verdict.heard(ended, [0, 70])
    verdict.files(folder, settled=True)
    if ended.code and (ended.code != 70 or crash not in ended.err):
        verdict.wrong.append(f"exit code {ended.code} is not told as a crash: {ended.err[-400:]}")
    return verdict


def _crashing(crash: str, call: int) -> Callable[[], None]:
    """Return what makes FCL crash in a call."""

    def prepare() -> None:
        import fcl

        left = [call]
        for name in ("collide", "distance"):
            setattr(fcl, name, _counted(left, getattr(fcl, name), crash))

    return prepare


def _counted(left: list[int], made, crash: str):  # type: ignore[no-untyped-def]
    def call(*arguments):  # type: ignore[no-untyped-def]
        left[0] -= 1
        if left[0] == 0:
            exec(CRASHES[crash], {"ctypes": ctypes, "os": os, "signal": signal})
        return made(*arguments)

    return call


KINDS = (Kind("crashes of planners", 120, planner), Kind("crashes of FCL", 400, collision))
