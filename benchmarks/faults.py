"""Ten thousand kills, damages and hostile files: does anything of kinolab break, or last too long?

    python benchmarks/faults.py [--scale 0.01] [--kinds NAME,…] [--seed N] [--keep DIR] [--only N]

Each fault strikes a command, ``plan``, ``plan check`` or another one, that is a process of its own.
What became of it is judged from outside: by its exit code, its output, the files that are there
and the processes that are left. Each fault follows from the seed, its kind and its number, and
what was counted is kept in DIR, so that the script may be ended and started again.

Prints a Markdown table, writes ``faults.json`` to DIR, and returns 1 if anything was not as it is
promised. It needs Linux, and the rights of root to mount file systems and to be somebody else.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import sys
import tempfile
import time
import traceback
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fault_kinds import KINDS
from fault_kinds.sandbox import adopt_orphans
from fault_kinds.workshop import IMPROVED, PLAN, Kind, Verdict, Workshop
from gallery import describe

WARM = (("plot",), ("execute", "--runs", "3"), ("video", "--size", "64x64", "--fps", "2"))
HEADS = (
    "faults", "how many", "tracebacks", "partial files", "wrong", "beyond its time",
    "time [s]", "of the processor [s]",
)  # fmt: skip


def entered(place: Path) -> None:
    """Begin anew with caches of its own, which must be known before anything is imported."""
    wanted = {
        "KINOLAB_CACHE": str(place / "cache"),
        "NUMBA_CACHE_DIR": str(place / "numba"),
        "OPENBLAS_NUM_THREADS": "1",
    }
    if any(os.environ.get(name) != value for name, value in wanted.items()):
        script = Path(__file__).absolute()
        arguments = [*sys.argv[1:], "--keep", str(place)]
        os.execve(sys.executable, [sys.executable, script, *arguments], {**os.environ, **wanted})


def begun(place: Path) -> Workshop:
    """Return the workshop, all of its commands compiled and imported."""
    shop, folder = Workshop(place), place / "first"
    scratch = str(folder)
    if not (place / "compiled").exists():  # what is compiled must not count as time of a fault
        ended = shop.run("warm-up", limit=1800.0, fresh=True)
        if ended.code:
            raise SystemExit(ended.err)
        (place / "compiled").touch()
    shop.load(
        [[*PLAN[:2], "--seed", "1", "--out", scratch], ["check", scratch]]
        + [[word, scratch, *further] for word, *further in WARM]
        + [["view", scratch, "--no-browser"], ["help", "scenario"]]
    )
    return shop


def warmed(shop: Workshop) -> None:
    """Load compiled loops into this process, so that those forked from it have them."""
    from kinolab.cli import run, supervisor  # noqa: F401  # which commands here did without
    from kinolab.concurrency import rows

    os.chdir(shop.place)
    stdout, sys.stdout = sys.stdout, open(os.devnull, "w")  # noqa: SIM115
    try:
        run([*PLAN, "--seed", "1", "--quiet", "--out", "warm"])
        run([*IMPROVED, "--seed", "1", "--quiet", "--out", "warm"])
        run(["check", "warm", "--quiet"])
        run(["execute", "warm", "--runs", "3", "--quiet"])
    finally:
        sys.stdout = stdout
    rows._threads().shutdown()
    rows._threads.cache_clear()
    until = time.monotonic() + 10.0
    while (tasks := len(os.listdir("/proc/self/task"))) > 1 and time.monotonic() < until:
        time.sleep(0.01)  # for the last of them to leave
    if tasks > 1:
        raise SystemExit(f"{tasks} threads: a process that was forked would lack all but one")


def kept(path: Path, seed: int) -> dict[tuple[str, int], dict[str, Any]]:
    """Return what was counted so far with a seed."""
    lines = path.read_text().splitlines() if path.is_file() else []
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    return {(one["kind"], one["number"]): one for one in entries if one["seed"] == seed}


def strike(shop: Workshop, kind: Kind, number: int, seed: int) -> Verdict:
    """Try one fault; where it was not made as it was meant, that counts as wrong."""
    try:
        return kind.strike(shop, random.Random(f"{seed}/{kind.name}/{number}"))
    except Exception:
        return Verdict("of this script", wrong=[traceback.format_exc()])


def table(kinds: list[Kind], tally: dict[tuple[str, int], dict[str, Any]]) -> list[list[Any]]:
    """Return the rows of the table, the last one of sums."""
    rows = []
    for kind in kinds:
        found = [entry for (name, _), entry in tally.items() if name == kind.name]
        counts = [len(found), *(sum(map(_number, (e[key] for e in found))) for key in COUNTED)]
        if found:
            seconds = (round(sum(entry[key] for entry in found)) for key in ("total", "cpu"))
            rows.append([kind.name, *counts, *seconds])
    return [*rows, ["all", *(sum(row[k] for row in rows) for k in range(1, len(HEADS)))]]


def _worked() -> float:
    """Return the processor time of this process and of all that it has buried, in [s]."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(use.ru_utime + use.ru_stime for use in map(resource.getrusage, kinds))


COUNTED = ("tracebacks", "partial", "wrong", "late")


def _number(value: int | list[str]) -> int:
    return value if isinstance(value, int) else len(value)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Try faults.")
    parser.add_argument("--scale", type=float, default=1.0, help="share of all faults")
    parser.add_argument("--kinds", metavar="NAME,…", help="beginnings of their names")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument(
        "--only", type=int, metavar="N", help="one fault of each kind, by its number"
    )
    parser.add_argument("--keep", metavar="DIR", help="where everything is kept")
    options = parser.parse_args()
    place = Path(options.keep or tempfile.mkdtemp()).absolute()
    place.mkdir(parents=True, exist_ok=True)
    entered(place)
    adopt_orphans()
    path, warm = place / "faults.jsonl", False
    tally = kept(path, options.seed)
    kinds = sorted(KINDS, key=lambda kind: not kind.cold)
    if options.kinds:
        kinds = [kind for kind in kinds if kind.name.startswith(tuple(options.kinds.split(",")))]
    shop = begun(place)
    for kind in kinds:
        if not (kind.cold or warm):
            warmed(shop)
            warm = True
        numbers = range(max(1, round(kind.count * options.scale)))
        for number in numbers if options.only is None else [options.only]:
            if (kind.name, number) in tally and options.only is None:
                continue
            since, work = time.monotonic(), _worked()
            verdict = strike(shop, kind, number, options.seed)
            entry = {"seed": options.seed, "kind": kind.name, "number": number, **asdict(verdict)}
            entry |= {"total": time.monotonic() - since, "cpu": _worked() - work}
            tally[kind.name, number] = entry
            with path.open("a") as file:
                file.write(json.dumps(entry) + "\n")
            if not verdict.sound:
                print(f"{kind.name} {number}: {verdict}", file=sys.stderr, flush=True)
        print(f"{kind.name}: {len(numbers)} faults", file=sys.stderr, flush=True)
    rows = table(kinds, tally)
    summary = {"machine": describe(), "columns": HEADS, "rows": rows}
    (place / "faults.json").write_text(json.dumps(summary, indent=1) + "\n")
    print(f"{describe()}\n\n| {' | '.join(HEADS)} |\n|{' --- |' * len(HEADS)}")
    for row in rows:
        print(f"| {' | '.join(map(str, row))} |")
    return int(any(rows[-1][2:6]))


if __name__ == "__main__":
    sys.exit(main())
