"""Clocks that jump, and files from the future."""

from __future__ import annotations

import os
import random
import shutil
import time
from collections.abc import Callable

from .kills import place_for, words_of
from .storage import mounted
from .workshop import IMPROVED, Kind, Verdict, Workshop

YEAR = 31_557_600  # [s]


def _jumping(rng: random.Random) -> Callable[[], float]:
    """Return a clock that is years off, and jumps every now and then."""
    own, true = random.Random(rng.random()), time.time

    def tell() -> float:
        if own.random() < 0.3:
            tell.off = own.choice((0.0, 3600.0, -3600.0, YEAR, -YEAR, 30 * YEAR, -50 * YEAR))  # type: ignore[attr-defined]
        return max(0.0, true() + tell.off)  # type: ignore[attr-defined]

    tell.off = 0.0  # type: ignore[attr-defined]
    return tell


def jump(shop: Workshop, rng: random.Random) -> Verdict:
    """Let the clock jump while a command is at work."""
    name = rng.choice(
        ("plan", "plan, improved", "plan --jobs 2, threads", "plan check", "plan execute")
    )
    verdict = Verdict(f"jumps of the clock in {name}")
    folder, clock = place_for(shop, name, "clock"), _jumping(rng)

    def prepare() -> None:
        time.time = clock
        time.time_ns = lambda: int(1e9 * clock())

    ended = shop.run(*words_of(name, folder), prepare=prepare)
    verdict.seconds = ended.seconds
    verdict.heard(ended, [0])
    verdict.files(folder, settled=True)
    if name == "plan, improved":
        shop.compare(verdict, folder, 1, IMPROVED)
    elif "jobs" not in name:
        shop.compare(verdict, folder, 1)
    return verdict


STAMPS = (
    0,
    1,
    -1,
    -(2**31),
    2**31,
    2**32,
    2**33,
    4102444800,
    -62135596801,
    253402300800,
    2**36,
    2**40,
)


def stamped(shop: Workshop, rng: random.Random) -> Verdict:
    """Give the files of a run, or of the cache, times of another age."""
    name = rng.choice(("plan", "plan check", "plan view", "plan execute", "plan plot"))
    stamp = rng.choice(STAMPS)
    verdict = Verdict(f"files of time {stamp} for {name}")
    with mounted(shop.place / "memory"):  # where times may be later than on most disks
        folder = shop.place / "memory" / "run"
        shutil.copytree(shop.done(1), folder)
        cache = shop.place / "memory" / "cache"
        shutil.copytree(shop.place / "cache", cache)
        for path in (folder, *folder.rglob("*"), *cache.glob("*")):
            os.utime(path, (stamp, stamp))
        ended = shop.run(*words_of(name, folder), environment={"KINOLAB_CACHE": str(cache)})
        verdict.seconds = ended.seconds
        verdict.heard(ended, [0])
        verdict.files(folder, settled=True)
        shop.compare(verdict, folder, 1)
    return verdict


KINDS = (Kind("jumps of the clock", 200, jump), Kind("files of another age", 200, stamped))
