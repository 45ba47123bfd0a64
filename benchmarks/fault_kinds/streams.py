"""Standard streams that are closed, full, or read by nobody."""

from __future__ import annotations

import os
import random
from collections.abc import Callable

from .kills import COMMANDS, place_for, words_of
from .workshop import Kind, Verdict, Workshop

STREAMS = {0: "stdin", 1: "stdout", 2: "stderr"}
KINDS_OF_STREAMS = ("closed", "full", "read by nobody")


def streams(shop: Workshop, rng: random.Random) -> Verdict:
    """Let a command do without some of its streams."""
    numbers = sorted(rng.sample((0, 1, 2), rng.randint(1, 3)))
    how = rng.choice(KINDS_OF_STREAMS)
    name = rng.choice(("plan", "plan, improved", "plan --jobs 2, threads", "plan check"))
    told = ", ".join(STREAMS[number] for number in numbers)
    verdict = Verdict(f"{told} {how} for {name}")
    folder = place_for(shop, name, "streams")
    fresh = rng.random() < 0.3
    ended = shop.run(*words_of(name, folder), prepare=_without(numbers, how), fresh=fresh)
    verdict.seconds = ended.seconds
    lost = how == "full" and 1 in numbers  # the result cannot be told
    verdict.heard(ended, [2] if lost else [0])
    verdict.files(folder, settled=True)
    if not COMMANDS[name][1] and "jobs" not in name:
        words = COMMANDS[name][0]
        shop.compare(verdict, folder, 1, words)
    return verdict


def _without(numbers: list[int], how: str) -> Callable[[], None]:
    """Return what spoils the streams of some numbers."""

    def prepare() -> None:
        for number in numbers:
            if how == "closed":
                os.close(number)
                continue
            if how == "full":
                handle = os.open("/dev/full", os.O_RDWR)
            else:
                reader, handle = os.pipe()
                os.close(reader)
            os.dup2(handle, number)
            os.close(handle)

    return prepare


KINDS = (Kind("strange streams", 300, streams),)
