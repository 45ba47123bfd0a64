"""A study of 2000 runs under faults: does it lose a row, or change one?

    python benchmarks/study_faults.py [--seeds N] [--faults NAME,…] [--keep DIR] [--jobs N]

Runs the same study once undisturbed and once under each fault, goes on with ``--resume`` where it
was ended, and compares all rows but for times. With 100 seeds it has 2000 runs. Faults:

- ``interrupt``: Ctrl-C after every 300 rows.
- ``workers``: SIGKILL of a worker process every 20 s.
- ``scheduler``: SIGKILL of Dask's scheduler after 500 rows; a new one goes on.
- ``dask_workers``: SIGKILL of a Dask worker every 20 s.
- ``disk``: the disk is full after about a third of the rows; it is given room again. Needs the
  right to mount a file system.

Prints a Markdown table; returns 1 if a row was lost or differs.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
from gallery import describe

ENTER = "from kinolab.cli import main; main()"
STUDY = """
schema = 1
title = "Runs under faults"
seeds = {seeds}
[limits]
iterations = 3000
cpu = 60.0
[[case]]
scenarios = ["rolling_disk_maze", "pendulum_swingup"]
planners = ["rrt_fast", "kpiece_fast"]
[[case]]
scenarios = ["rolling_disk_maze"]
planners = ["rrt_fast"]
sweep = {{ "planner.goal_bias" = [0.02, 0.05, 0.1, 0.2], "start.x" = [0.5, 0.6, 0.7, 0.8] }}
"""
EVERY = 20.0  # [s] between kills
EACH_ROWS = 300  # between interrupts
WORKERS = ("kinolab.studies.worker_process",)


@dataclass
class Fate:
    """How a study fared.

    Attributes:
        fault: Name of the fault.
        ended: How often the command ended before all rows were there.
        hits: How often the fault struck.
        rows: Rows at the end.
        differing: Rows that differ from the undisturbed study's, or are missing.
        seconds: Time of all.
    """

    fault: str
    ended: int
    hits: int
    rows: int
    differing: int
    seconds: float


def command(study: Path, folder: Path, *further: str) -> subprocess.Popen[bytes]:
    """Start the study, or go on with it."""
    arguments = ["bench", str(study), "--out", str(folder), "--resume", "--quiet", *further]
    return subprocess.Popen([sys.executable, "-c", ENTER, *arguments], start_new_session=True)


def count(folder: Path) -> int:
    """Return how many rows there are."""
    path = folder / "rows.jsonl"
    return path.read_bytes().count(b"\n") if path.is_file() else 0


def workers_of(process: subprocess.Popen[bytes], named: tuple[str, ...]) -> list[psutil.Process]:
    """Return the worker processes below a process, by what their command lines name."""
    found = []
    with suppress(psutil.Error):
        for child in psutil.Process(process.pid).children(recursive=True):
            with suppress(psutil.Error):
                if any(word in " ".join(child.cmdline()) for word in named):
                    found.append(child)
    return found


def until_complete(
    start: Callable[[], subprocess.Popen[bytes]], disturb: Callable
) -> tuple[int, int]:
    """Start again until the command succeeds; return how often it ended early, and all hits."""
    ended = hits = 0
    while True:
        process = start()
        while process.poll() is None:
            time.sleep(0.2)
            hits += disturb(process)
        if process.returncode == 0:
            return ended, hits
        ended += 1
        if ended > 50:
            raise SystemExit("the study does not end")


def interrupted(folder: Path) -> Callable[[subprocess.Popen[bytes]], int]:
    """Return a disturbance: Ctrl-C after every so many rows."""
    last = [count(folder)]

    def disturb(process: subprocess.Popen[bytes]) -> int:
        if count(folder) < last[0] + EACH_ROWS:
            return 0
        os.killpg(process.pid, signal.SIGINT)
        process.wait()
        last[0] = count(folder)
        return 1

    return disturb


def killing(named: tuple[str, ...]) -> Callable[[subprocess.Popen[bytes]], int]:
    """Return a disturbance: SIGKILL of the next worker every so many seconds."""
    last, turn = [time.monotonic()], [0]

    def disturb(process: subprocess.Popen[bytes]) -> int:
        if time.monotonic() < last[0] + EVERY:
            return 0
        last[0] = time.monotonic()
        found = workers_of(process, named)
        if not found:
            return 0
        turn[0] += 1
        with suppress(psutil.Error):
            found[turn[0] % len(found)].kill()
        return 1

    return disturb


@contextmanager
def cluster(port: int) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Run a scheduler and two workers as somebody starts them by hand."""
    address = f"tcp://127.0.0.1:{port}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    module = [sys.executable, "-m"]
    scheduler = subprocess.Popen(
        [*module, "distributed.cli.dask_scheduler", "--port", str(port), "--no-dashboard"], **quiet
    )
    time.sleep(4.0)
    worker = [*module, "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    workers = [subprocess.Popen([*worker, "--nworkers", "2", "--death-timeout", "30"], **quiet)]
    time.sleep(6.0)
    try:
        yield [scheduler, *workers]
    finally:
        for process in [*workers, scheduler]:
            with suppress(psutil.Error):
                for child in psutil.Process(process.pid).children(recursive=True):
                    child.kill()
            process.kill()
            process.wait()


def under_scheduler(study: Path, folder: Path) -> tuple[int, int]:
    """Kill the scheduler once, then go on with another."""
    with cluster(18786) as processes:
        process = command(study, folder, "--dask", "tcp://127.0.0.1:18786")
        while count(folder) < 500 and process.poll() is None:
            time.sleep(0.2)
        processes[0].kill()
        process.wait()
    ended = int(process.returncode != 0)
    with cluster(18787):
        process = command(study, folder, "--dask", "tcp://127.0.0.1:18787")
        process.wait()
    return ended, 1


@contextmanager
def small_disk(folder: Path, kilobytes: int) -> Iterator[Path]:
    """Mount a small file system in memory."""
    place = folder / "disk"
    place.mkdir()
    size = f"size={kilobytes}k"
    subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(place)], check=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", str(place)], check=False)


def under_full_disk(study: Path, folder: Path, kilobytes: int, jobs: str) -> tuple[int, int, int]:
    """Fill the disk, then give it room; return how often it ended, hits, and differing rows."""
    with small_disk(folder, kilobytes) as place:
        out, hits = place / "study", 0
        ended = 0
        while True:
            process = command(study, out, "--jobs", jobs)
            process.wait()
            if process.returncode == 0:
                break
            ended, hits, kilobytes = ended + 1, hits + 1, kilobytes * 2
            size = f"remount,size={kilobytes}k"
            subprocess.run(["mount", "-o", size, str(place)], check=True)
            if ended > 10:
                raise SystemExit("the study does not end")
        return ended, hits, compared(folder / "reference", out)


def compared(reference: Path, folder: Path) -> int:
    """Return how many rows differ from the undisturbed study's, or are missing."""
    import pyarrow.parquet as pq

    from kinolab.studies.columns import COLUMNS

    lasting = [column.name for column in COLUMNS if not column.timed]
    one, two = (
        {row["index"]: [row[n] for n in lasting] for row in pq.read_table(path).to_pylist()}
        for path in (reference / "results.parquet", folder / "results.parquet")
    )
    return sum(one.get(index) != two.get(index) for index in {*one, *two})


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Run a study under faults.")
    parser.add_argument("--seeds", type=int, default=100, metavar="N")
    known = ("interrupt", "workers", "scheduler", "dask_workers", "disk")
    parser.add_argument("--faults", default=",".join(known), metavar="NAME,…")
    parser.add_argument("--jobs", default="2", metavar="N")
    parser.add_argument("--keep", metavar="DIR", help="where the folders of the studies are kept")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(options.keep or temporary)
        place.mkdir(parents=True, exist_ok=True)
        study = place / "faults.toml"
        study.write_text(STUDY.format(seeds=options.seeds), encoding="utf-8")
        reference = place / "reference"
        begun = time.monotonic()
        command(study, reference, "--jobs", options.jobs).wait()
        fates = [Fate("none", 0, 0, count(reference), 0, time.monotonic() - begun)]
        print(fates[0], file=sys.stderr, flush=True)
        for fault in options.faults.split(","):
            begun, folder = time.monotonic(), place / fault
            local = lambda own=folder: command(study, own, "--jobs", options.jobs)  # noqa: E731
            if fault == "interrupt":
                ended, hits = until_complete(local, interrupted(folder))
            elif fault == "workers":
                ended, hits = until_complete(local, killing(WORKERS))
            elif fault == "dask_workers":
                dask = lambda own=folder: command(study, own, "--dask", "local:2")  # noqa: E731
                ended, hits = until_complete(dask, killing(("spawn_main",)))
            elif fault == "scheduler":
                ended, hits = under_scheduler(study, folder)
            else:
                third = max(64, (reference / "rows.jsonl").stat().st_size // 3000)
                ended, hits, wrong = under_full_disk(study, place, third + 60, options.jobs)
                seconds = time.monotonic() - begun
                fates.append(Fate(fault, ended, hits, count(reference), wrong, seconds))
                print(fates[-1], file=sys.stderr, flush=True)
                continue
            wrong, seconds = compared(reference, folder), time.monotonic() - begun
            fates.append(Fate(fault, ended, hits, count(folder), wrong, seconds))
            print(fates[-1], file=sys.stderr, flush=True)
    print(f"{describe()}\n")
    print("| fault | struck | command ended early | rows | lost or different | time [s] |")
    print("| --- | --- | --- | --- | --- | --- |")
    for one in fates:
        cells = (one.fault, one.hits, one.ended, one.rows, one.differing, f"{one.seconds:.0f}")
        print(f"| {' | '.join(map(str, cells))} |")
    return int(any(one.differing for one in fates))


if __name__ == "__main__":
    sys.exit(main())
