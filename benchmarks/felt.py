"""What somebody waits for: from Enter to verdict, page and film, against another commit.

    python benchmarks/felt.py COMMIT [--scenarios NAME,...] [--checks NAME,...] [--repeats 5]
                              [--cold 1] [--folder DIR]

Both versions are installed as users do, each into an environment of its own, and take turns. *Cold*
runs begin with empty caches; *warm* ones come after one that does not count. All times are from the
outside, by the clock, in [s]: medians, and in brackets how often the older version takes that long;
below, the geometric means of these ratios over the scenarios. *Picture* and *film* are there when
the folder of the run first has a page, or a film, beside a report.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import geometric_mean, median

ROOT = Path(__file__).parents[1]
STAGES = ("picture", "film", "verdict", "summary", "end", "motion")
FILES = {"scene.html": "picture", "animation.gif": "film"}
LOOK_SECONDS = 0.005  # [s] between two looks into the folder of a run
WORDS = {"verified": "verdict", "solved:": "summary"}  # how a line begins that ends a stage
PLAN = "rolling_disk_maze"
LONG = "submarine_corridor,diffdrive_warehouse,crane_factory,snakeboard_park,vehicle_parking"


@dataclass(frozen=True)
class Version:
    """An installed version of kinolab."""

    name: str
    environment: Path
    size: int  # of what is installed, in [MB]

    def run(self, *words: str, caches: Path, folder: Path) -> dict[str, float]:
        """Run ``plan``; return when its stages ended, and how long the motion is, in [s]."""
        own = {"NUMBA_CACHE_DIR": str(caches / "numba"), "XDG_CACHE_HOME": str(caches)}
        ended: dict[str, float] = {}
        begun, place = time.perf_counter(), folder / "runs" / (words[0] if words else "")
        over = threading.Event()

        def look() -> None:
            """Note when the first pictures are there."""
            while not over.wait(LOOK_SECONDS):
                for name, stage in FILES.items():
                    if (place / name).is_file() and (place / "report.json").is_file():
                        ended.setdefault(stage, time.perf_counter() - begun)

        looking = threading.Thread(target=look)
        looking.start()
        process = subprocess.Popen(
            [self.environment / "bin" / "plan", *words],
            cwd=folder, env={**os.environ, **own}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert process.stdout is not None
        for line in process.stdout:
            stage = WORDS.get(line.split(" ")[0].strip())
            if stage:
                ended[stage] = time.perf_counter() - begun
        process.wait()
        ended["end"] = time.perf_counter() - begun
        over.set()
        looking.join()
        report = place / "report.json"
        if report.is_file():
            ended["motion"] = float(json.loads(report.read_text())["duration"] or 0.0)
        return ended


def installed(name: str, source: Path, folder: Path) -> Version:
    """Install a source tree into an environment of its own."""
    environment = folder / name
    if not environment.is_dir():
        subprocess.run([sys.executable, "-m", "venv", environment], check=True)
        subprocess.run([environment / "bin" / "pip", "install", "-q", source], check=True)
        subprocess.run(
            [environment / "bin" / "python", "-m", "compileall", "-q", environment], check=False
        )
    files = (environment / "lib").rglob("*")
    size = sum(file.stat().st_size for file in files if file.is_file())
    return Version(name, environment, round(size / 1e6))


def exported(commit: str, folder: Path) -> Path:
    """Write the files of a commit into a folder."""
    target = folder / f"source-{commit}"
    target.mkdir(exist_ok=True)
    packed = subprocess.run(["git", "archive", commit], cwd=ROOT, check=True, capture_output=True)
    subprocess.run(["tar", "x", "-C", target], input=packed.stdout, check=True)
    return target


def measured(
    versions: list[Version], words: list[str], repeats: int, folder: Path, *, cold: bool = False
) -> dict[str, dict[str, float]]:
    """Return medians of all stages by version; the versions take turns."""
    times: dict[str, list[dict[str, float]]] = {version.name: [] for version in versions}
    for k in range(repeats + (not cold)):
        for version in versions:
            caches = folder / f"caches-{version.name}"
            with tempfile.TemporaryDirectory() as place, tempfile.TemporaryDirectory() as empty:
                own = Path(empty) if cold else caches
                found = version.run(*words, caches=own, folder=Path(place))
            if k or cold:
                times[version.name].append(found)
    return {
        name: {stage: median(one[stage] for one in runs if stage in one) for stage in STAGES
               if any(stage in one for one in runs)}
        for name, runs in times.items()
    }  # fmt: skip


def started(versions: list[Version], words: list[str], repeats: int) -> dict[str, float]:
    """Return the median time of a command of each environment, in [s]."""
    times: dict[str, list[float]] = {version.name: [] for version in versions}
    for _ in range(repeats + 1):
        for version in versions:
            begun = time.perf_counter()
            command = [version.environment / "bin" / words[0], *words[1:]]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            times[version.name].append(time.perf_counter() - begun)
    return {name: median(found[1:]) for name, found in times.items()}


def checked(
    versions: list[Version], name: str, repeats: int, folder: Path
) -> dict[str, dict[str, float]]:
    """Return the median time in which each version checks the same long plan, as it was found."""
    plan = folder / f"plan-{name}"
    raw = [name, "--seed", "1", "--no-optimize", "--no-animation", "--out", str(plan)]
    if not plan.is_dir():
        versions[0].run(*raw, caches=folder / f"caches-{versions[0].name}", folder=folder)
    found = measured(versions, ["check", str(plan)], repeats, folder)
    motion = float(json.loads((plan / "report.json").read_text())["duration"])
    return {name: {**stages, "motion": motion} for name, stages in found.items()}


def rows(
    versions: list[Version], options: argparse.Namespace, folder: Path
) -> Iterator[tuple[str, dict[str, dict[str, float]]]]:
    """Yield what was measured, with the medians of each version."""
    for words in (["python", "-c", "import kinolab"], ["plan", "--help"]):
        found = started(versions, words, options.repeats)
        yield " ".join(words), {name: {"end": seconds} for name, seconds in found.items()}
    if options.cold:
        found = measured(versions, [PLAN, "--seed", "1"], options.cold, folder, cold=True)
        yield f"plan {PLAN}, cold", found
    for name in filter(None, options.checks.split(",")):
        found = checked(versions, name, options.repeats, folder)
        yield f"plan check, {name} as found", found
    for name in filter(None, options.scenarios.split(",")):
        yield f"plan {name}", measured(versions, [name, "--seed", "1"], options.repeats, folder)


def main() -> int:
    """Measure, and print a table row by row."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("commit", help="the older version")
    parser.add_argument("--scenarios", default=PLAN)
    parser.add_argument("--checks", default=LONG, help="scenarios whose raw plans are checked")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--cold", type=int, default=1, help="runs with empty caches")
    parser.add_argument("--folder", type=Path, help="where environments and caches stay")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        older = installed(options.commit, exported(options.commit, folder), folder)
        versions = [older, installed("here", ROOT, folder)]
        print(f"load {os.getloadavg()[0]:.1f} at the beginning, {os.cpu_count()} cores")
        print(f"installed: {older.size} MB before, {versions[1].size} MB now\n")
        print("| command |", *(f"{stage} |" for stage in STAGES))
        print("| --- |", *("--- |" for _ in STAGES))
        ratios: dict[str, list[float]] = {}
        for title, found in rows(versions, options, folder):
            before, now = found[older.name], found["here"]
            cells = [
                f"{now[stage]:.2f} ({before[stage] / now[stage]:.1f})" if stage in before else "–"
                for stage in STAGES
            ]
            print(f"| `{title}` |", *(f"{cell} |" for cell in cells), flush=True)
            if title.removeprefix("plan ") in options.scenarios.split(","):
                for stage in before.keys() & now.keys():
                    ratios.setdefault(stage, []).append(now[stage] / before[stage])
        means = [f"{geometric_mean(ratios[s]):.2f} |" if s in ratios else "– |" for s in STAGES]
        print("| mean of scenarios, of before |", *means)
        print(f"\nload {os.getloadavg()[0]:.1f} at the end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
