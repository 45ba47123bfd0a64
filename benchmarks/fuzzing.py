"""Readers of files and of the command line under damaged inputs, for minutes or for hours.

    python benchmarks/fuzzing.py [TARGET ...] [--minutes 2] [--hours H] [--out fuzzing] [--engine E]

The targets are those of `tests/fuzz/targets.py`, which also says what counts as a bug. Each one is
run in a process of its own, with a limit of processor time for every input and a limit of memory,
`--minutes` of the clock at a time; with `--hours`, again and again until so much processor time has
been used in all, the one that has had the least of it first. What was found lies in `OUT/findings`,
inputs that were worth keeping in `OUT/corpus`, and `OUT/tally.json` has the sums over all runs that
were made with the same OUT, which are printed as a Markdown table.

The engine is atheris where it is installed (`pip install atheris`, which kinolab itself does not
need): it sees which lines of kinolab an input leads through, and goes on from inputs that lead
through new ones. The other one, `own`, goes on from inputs that get a new answer.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import logging
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))  # for the targets, which tests run, too

SPARE = 60.0  # [s] by which a process may be late before it is ended
TOLD = 2.0  # [s] between two notes of how far a process is
MOST_ALIKE = 3  # inputs kept of one bug
MUCH = 2**28  # [bytes] by which no small input may make a process grow
MOST_KEPT = 3000  # inputs of a target that the engine of our own goes on from
PARSERS = ["trimesh.exchange"]  # of others, which are seen from inside like kinolab
COMPILED_ELSEWHERE = "kinolab.dynamics.codegen.state_space"
OPTIONS = ("-timeout=1000000", "-handle_alrm=0", "-rss_limit_mb=0", "-max_len=60000")


class TooLongError(BaseException):
    """An input takes too long; no reader catches it."""


@dataclass
class Watch:
    """Runs a target on inputs, and keeps those that show a bug.

    Attributes:
        executions: So far.
    """

    run: Callable[[bytes], None]
    name: str
    out: Path
    seconds: float
    executions: int = 0
    begun: float = field(default_factory=time.process_time)
    noted: float = 0.0
    _peak: int = 0
    _short_of_memory: bool = False
    _alike: dict[str, int] = field(default_factory=dict)

    def begin(self) -> None:
        """Watch the time and the memory of everything from now on."""
        from kinolab.errors import InputError
        from kinolab.untrusted import MEMORY

        logging.disable(logging.CRITICAL)  # warnings of damaged caches
        signal.signal(signal.SIGPROF, _too_long)
        grown = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (grown + MEMORY,) * 2)
        plain = InputError.__init__

        def noting(error: InputError, mistakes: Any) -> None:
            self._short_of_memory |= isinstance(sys.exception(), MemoryError)
            plain(error, mistakes)

        InputError.__init__ = noting  # type: ignore[method-assign]
        self._peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        self.begun = time.process_time()

    def __call__(self, data: bytes) -> None:
        """Give an input to the reader."""
        (self.out / "current" / self.name).write_bytes(data)
        self.executions += 1
        try:
            signal.setitimer(signal.ITIMER_PROF, self.seconds)
            self.run(data)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        except TooLongError as error:
            self.keep("hang", error, data)
        except BaseException as error:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            if isinstance(error, KeyboardInterrupt):
                raise
            self.keep("memory" if isinstance(error, MemoryError) else "crash", error, data)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if self._short_of_memory or (peak - self._peak) * 1024 > MUCH:
            self.keep("memory", MemoryError(f"{(peak - self._peak) / 1024:.0f} MB more"), data)
        self._short_of_memory, self._peak = False, max(peak, self._peak)
        if time.monotonic() - self.noted > TOLD:
            self.note()

    def keep(self, kind: str, error: BaseException, data: bytes) -> None:
        """Keep an input that shows a bug, with what was raised."""
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if "kinolab" in frame.filename]
        at = own[-1] if own else frames[-1] if frames else None
        where = f"{Path(at.filename).stem}.{at.name}.{at.lineno}" if at else "outside"
        bug = re.sub(r"[^\w.]", "", f"{kind}-{type(error).__name__}-{where}")
        self._alike[bug] = self._alike.get(bug, 0) + 1
        folder = self.out / "findings" / self.name
        folder.mkdir(parents=True, exist_ok=True)
        if len(list(folder.glob(f"{bug}-*.input"))) >= MOST_ALIKE:
            return
        path = folder / f"{bug}-{hashlib.sha256(data).hexdigest()[:8]}"
        path.with_name(f"{path.name}.input").write_bytes(data)
        told = "".join(traceback.format_exception(error))
        path.with_name(f"{path.name}.txt").write_text(told, encoding="utf-8", errors="replace")

    def note(self) -> None:
        """Write down how far it is, for the process that started this one."""
        self.noted = time.monotonic()
        facts = {"cpu_s": time.process_time() - self.begun, "executions": self.executions}
        draft = self.out / "current" / f"{self.name}.draft"
        draft.write_text(json.dumps({**facts, "bugs": self._alike}))
        draft.replace(self.out / "current" / f"{self.name}.json")


def _too_long(*_: object) -> None:
    raise TooLongError


# --- one target, in this process ---


def fuzz(name: str, out: Path, seconds: float, seed: int, engine: str) -> None:
    """Run one target for some seconds of the clock."""
    for folder in (out / "current", out / "corpus" / name):
        folder.mkdir(parents=True, exist_ok=True)
    if engine == "atheris":
        _with_atheris(name, out, seconds, seed)
        return
    from tests.fuzz.targets import TARGETS

    target = TARGETS[name]
    watch = Watch(target.run, name, out, target.seconds)
    random, until, answers = Random(seed), time.monotonic() + seconds, set[str]()
    kept = [*target.seeds().values()]
    kept += [path.read_bytes() for path in sorted((out / "corpus" / name).iterdir())[:MOST_KEPT]]
    _ready(watch, kept[: len(target.seeds())])
    with _Answers() as last:
        while time.monotonic() < until:
            data = target.mutate(random.choice(kept), random)
            last.clear()
            watch(data)
            told = re.sub(r"\d+|'[^']*'|\"[^\"]*\"", "#", "".join(last))[:300]
            if told not in answers and len(answers) < MOST_KEPT:
                answers.add(told)
                kept.append(data)
                place = out / "corpus" / name / hashlib.sha1(data).hexdigest()
                place.write_bytes(data)
    watch.note()


def _ready(watch: Watch, seeds: list[bytes]) -> None:
    """Compile and import all that a target needs before time and memory are watched."""
    for data in seeds:
        with suppress(Exception):  # it is told when it comes again
            watch.run(data)
    watch.begin()


class _Answers:
    """What readers answer inside the context: the texts of their errors."""

    def __enter__(self) -> list[str]:
        from kinolab.errors import Mistake

        self._plain, told = Mistake.__init__, list[str]()

        def noting(mistake: Mistake, where: str, what: str, remedy: str = "") -> None:
            self._plain(mistake, where, what, remedy)
            told.append(what)

        Mistake.__init__ = noting  # type: ignore[method-assign]
        return told

    def __exit__(self, *_: object) -> None:
        from kinolab.errors import Mistake

        Mistake.__init__ = self._plain  # type: ignore[method-assign]


def _with_atheris(name: str, out: Path, seconds: float, seed: int) -> None:
    import atheris

    packages = [f"kinolab.{part}" for part in _packages(name)] + PARSERS
    with atheris.instrument_imports(include=packages, exclude=_compiled()):
        from tests.fuzz.targets import CORPUS, TARGETS

        target = TARGETS[name]
        watch = Watch(target.run, name, out, target.seconds)
        _ready(watch, list(target.seeds().values()))

    def mutate(data: bytes, most: int, number: int) -> bytes:
        random = Random(number)
        if random.random() < 0.3:
            return atheris.Mutate(data, most)
        return target.mutate(bytes(data), random)[:most]

    corpus = [str(out / "corpus" / name), str(CORPUS / name)]
    timed = (f"-max_total_time={max(int(seconds), 1)}", f"-seed={seed}")
    place = f"-artifact_prefix={out / 'current'}/"
    arguments = [sys.argv[0], *OPTIONS, *timed, place, *corpus]
    atheris.Setup(arguments, watch, custom_mutator=mutate)
    atheris.Fuzz()


def _packages(name: str) -> tuple[str, ...]:
    """Return the parts of kinolab that a target leads through, before any of them is imported."""
    text = (ROOT / "tests" / "fuzz" / "targets.py").read_text(encoding="utf-8")
    at = text.index(f"def read_{name}(")
    head = text[text.rindex("@_target(", 0, at) : at]
    found = re.findall(rf'"((?:{"|".join(_parts())})(?:\.\w+)*)"', head)
    return tuple(found) or ("world.meshes", "world.obstacles")


def _compiled() -> list[str]:
    """Return modules whose bytecode becomes machine code, and must stay as it is.

    They compile functions of their own, or one of them is compiled elsewhere.
    """
    source = ROOT / "src"
    own = [
        ".".join(path.relative_to(source).with_suffix("").parts)
        for path in (source / "kinolab").rglob("*.py")
        if "kinolab.numerics.jit" in path.read_text(encoding="utf-8")
    ]
    return [*own, COMPILED_ELSEWHERE]


def _parts() -> list[str]:
    return [path.name for path in (ROOT / "src" / "kinolab").iterdir() if path.is_dir()]


# --- all of them, each in a process of its own ---


def one(
    name: str, out: Path, seconds: float, seed: int, engine: str, tally: dict[str, Any]
) -> None:
    """Run a target in another process, and add what came out to the tally."""
    (out / "current").mkdir(parents=True, exist_ok=True)
    note, current = out / "current" / f"{name}.json", out / "current" / name
    note.unlink(missing_ok=True)
    current.unlink(missing_ok=True)
    fast = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    scratch = tempfile.mkdtemp(prefix="kinolab_fuzzing", dir=fast)
    own = ["--child", name, "--out", str(out), "--seed", str(seed), "--engine", engine]
    command = [sys.executable, __file__, *own, "--minutes", str(seconds / 60)]
    ended, log = "", out / "current" / f"{name}.log"
    with log.open("wb") as stream:
        process = subprocess.Popen(
            command, stdout=stream, stderr=stream, env={**os.environ, "TMPDIR": scratch}
        )
        late = time.monotonic() + seconds + 2 * SPARE
        while process.poll() is None:
            time.sleep(0.2)
            idle = time.time() - note.stat().st_mtime if note.exists() else 0.0
            if idle > SPARE + 5 * TOLD or time.monotonic() > late:
                ended = "stuck" if idle > SPARE else "late"
                process.kill()
        process.wait()
    shutil.rmtree(scratch, ignore_errors=True)
    if (ended == "stuck" or process.returncode not in (0, -signal.SIGKILL)) and current.exists():
        folder = out / "findings" / name
        folder.mkdir(parents=True, exist_ok=True)
        place = folder / f"{ended or 'died'}-{process.returncode}-{int(time.time())}"
        shutil.copy(current, place.with_name(f"{place.name}.input"))
        shutil.copy(log, place.with_name(f"{place.name}.txt"))
    facts = json.loads(note.read_text()) if note.exists() else {"cpu_s": 0.0, "executions": 0}
    entry = tally.setdefault(name, {"cpu_s": 0.0, "executions": 0, "engines": {}, "edges": 0})
    entry["cpu_s"] += facts["cpu_s"]
    entry["turns"] = entry.get("turns", 0) + 1
    entry["executions"] += facts["executions"]
    entry["engines"][engine] = entry["engines"].get(engine, 0.0) + facts["cpu_s"]
    found = re.findall(rb"cov: (\d+)", log.read_bytes())
    entry["edges"] = max(entry["edges"], int(found[-1]) if found else 0)
    entry["corpus"] = len(list((out / "corpus" / name).glob("*")))
    entry["findings"] = sorted(p.stem for p in (out / "findings" / name).glob("*.input"))


def table(tally: dict[str, Any]) -> str:
    """Return the tally as a Markdown table."""
    lines = [
        "| target | CPU | executions | each second | edges | inputs kept | findings |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, entry in sorted(tally.items()):
        cpu, count = entry["cpu_s"], entry["executions"]
        lines.append(
            f"| {name} | {cpu / 60:.1f} min | {count} | {count / max(cpu, 1e-9):.0f} | "
            f"{entry['edges'] or ''} | {entry['corpus']} | {len(entry['findings'])} |"
        )
    cpu = sum(entry["cpu_s"] for entry in tally.values())
    count = sum(entry["executions"] for entry in tally.values())
    lines.append(f"| all | {cpu / 3600:.2f} h | {count} | {count / max(cpu, 1e-9):.0f} | | | |")
    return "\n".join(lines)


def _turns(names: list[str], tally: dict[str, Any], *, once: bool) -> Iterator[str]:
    """Yield every target once, or without end the one that has had the least processor time."""
    if once:
        yield from names
    while not once:
        yield min(names, key=lambda name: _had(tally.get(name, {})))


def _had(entry: dict[str, Any]) -> float:
    return float(entry.get("cpu_s", 0.0)) + float(entry.get("turns", 0))  # that failed, too


def main() -> None:
    """Parse the arguments and run."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("targets", nargs="*")
    parser.add_argument("--minutes", type=float, default=2.0, help="of the clock, at a time")
    parser.add_argument("--hours", type=float, help="of processor time in all, earlier runs too")
    parser.add_argument("--until", type=float, help="end at this time, in s since 1970")
    parser.add_argument("--out", type=Path, default=Path("fuzzing"))
    parser.add_argument("--engine", choices=("atheris", "own"))
    parser.add_argument("--seed", type=int, default=1, help=argparse.SUPPRESS)
    parser.add_argument("--child", help=argparse.SUPPRESS)
    given = parser.parse_args()
    engine = given.engine or ("atheris" if importlib.util.find_spec("atheris") else "own")
    out = given.out.resolve()
    if given.child:
        fuzz(given.child, out, given.minutes * 60, given.seed, engine)
        return
    from tests.fuzz.targets import TARGETS

    if unknown := sorted(set(given.targets) - set(TARGETS)):
        parser.error(f"no target is called {', '.join(unknown)}; known: {', '.join(TARGETS)}")
    out.mkdir(parents=True, exist_ok=True)
    path = out / "tally.json"
    tally: dict[str, Any] = json.loads(path.read_text()) if path.exists() else {}
    names = given.targets or list(TARGETS)
    once = given.hours is None and given.until is None
    for name in _turns(names, tally, once=once):
        one(name, out, given.minutes * 60, int(time.time()) % 2**31, engine, tally)
        path.write_text(json.dumps(tally, indent=1) + "\n")
        used = sum(entry["cpu_s"] for entry in tally.values()) / 3600
        if used >= (given.hours or math.inf) or time.time() > (given.until or math.inf):
            break
    print(table(tally))


if __name__ == "__main__":
    main()
