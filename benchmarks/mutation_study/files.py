"""Files of a run that somebody edited: a byte changed, a file left out, one of another run.

What is certified is what the run's own hashes vouch for: the list in ``certificate.json``, where
there is one, and the files below ``assets/`` that ``report.json`` lists. A change of these must be
refused, and one of the motion's two tables, of which each says what the other does. Of the rest the
judge says whether the plan is another: a scenario is read once more, as plain TOML, and compared in
all keys that a verdict depends on.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

from kinolab.errors import KinolabError
from kinolab.runs import check_run

from .faults import Generator
from .judge import Verdict
from .records import ACCEPTED, RAISED, REFUSED

CERTIFICATE = "certificate.json"
TABLES = ("trajectory.csv", "trajectory.npz")
PICTURES = ("scene.html", "animation.gif", "animation.mp4", "result.glb")
# Keys of a scenario that say how to search and how to show, and nothing of what is true.
OF_NO_ACCOUNT = ("title", "planner", "metric", "render", "schema")

Edit: TypeAlias = Callable[[Path, str, Path, Generator], bool]


def byte_changed(folder: Path, name: str, _other: Path, generator: Generator) -> bool:
    """Change one byte of a file to another one."""
    content = bytearray((folder / name).read_bytes())
    if not content:
        return False
    at = int(generator.integers(len(content)))
    content[at] = (content[at] + int(generator.integers(1, 256))) % 256
    (folder / name).write_bytes(content)
    return True


def digit_changed(folder: Path, name: str, _other: Path, generator: Generator) -> bool:
    """Change one digit of a text to another one."""
    content = bytearray((folder / name).read_bytes())
    digits = [i for i, byte in enumerate(content) if 48 <= byte <= 57]
    if not digits or name.endswith((".npz", ".stl", ".ply", ".glb")):
        return False
    at = digits[int(generator.integers(len(digits)))]
    content[at] = 48 + (content[at] - 48 + int(generator.integers(1, 10))) % 10
    (folder / name).write_bytes(content)
    return True


def left_out(folder: Path, name: str, _other: Path, _generator: Generator) -> bool:
    """Remove a file."""
    (folder / name).unlink()
    return True


def of_another_run(folder: Path, name: str, other: Path, _generator: Generator) -> bool:
    """Replace a file by another run's."""
    if not (other / name).is_file():
        return False
    content = (other / name).read_bytes()
    if content == (folder / name).read_bytes():
        return False
    (folder / name).write_bytes(content)
    return True


def cut_off(folder: Path, name: str, _other: Path, generator: Generator) -> bool:
    """Leave out the end of a file."""
    content = (folder / name).read_bytes()
    if len(content) < 2:
        return False
    (folder / name).write_bytes(content[: int(generator.integers(len(content)))])
    return True


EDITS: dict[str, Edit] = {
    "byte changed": byte_changed,
    "digit changed": digit_changed,
    "file left out": left_out,
    "file of another run": of_another_run,
    "file cut off": cut_off,
}


def names_in(folder: Path) -> list[str]:
    """Return the names of all files of a run, from its folder."""
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def certified(folder: Path) -> set[str]:
    """Return the names of the files that a run's hashes vouch for."""
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    found = {f"assets/{name}" for name in report["assets"]} | set(TABLES)
    if (folder / CERTIFICATE).is_file():
        found |= {CERTIFICATE, *hashed(folder)}
    return found


def hashed(folder: Path) -> set[str]:
    """Return the names of the files whose hashes a run's certificate has."""
    if not (folder / CERTIFICATE).is_file():
        return set()
    return _hashed(json.loads((folder / CERTIFICATE).read_text(encoding="utf-8")))


def _hashed(entry: Any) -> set[str]:
    """Return all keys of a certificate that have a SHA-256, however deep."""
    if not isinstance(entry, dict):
        return set()
    own = {k for k, v in entry.items() if isinstance(v, str) and len(v) == 64}
    return own.union(*(_hashed(v) for v in entry.values()))


def judged(name: str, edit: str, before: Path, after: Path) -> Verdict:
    """Judge an edit of a file of a run."""
    if name == CERTIFICATE and edit == "file left out":
        return Verdict("borderline", "the plan is the same, and nothing vouches for its files")
    if name in certified(before):
        if name == "trajectory.npz" and edit == "file left out" and name not in hashed(before):
            return Verdict("true", "the table is there all the same")
        return Verdict("false", "a certified file is another")
    if name == "scenario.toml":
        return _of_scenario(before / name, after / name)
    if name == "report.json":
        return _of_report(before / name, after / name)
    return Verdict("true", "nothing depends on it")


def _of_scenario(before: Path, after: Path) -> Verdict:
    if not after.exists():
        return Verdict("false", "what is solved is not said")
    try:
        found = tomllib.loads(after.read_text(encoding="utf-8"))
    except ValueError:
        return Verdict("false", "the scenario cannot be read")
    known = tomllib.loads(before.read_text(encoding="utf-8"))
    for key in OF_NO_ACCOUNT:
        found.pop(key, None)
        known.pop(key, None)
    if found == known:
        return Verdict("true", "the same in all keys that count")
    changed = [key for key in {*known, *found} if known.get(key) != found.get(key)]
    return Verdict("borderline", f"another problem: {', '.join(sorted(changed))}")


def _of_report(before: Path, after: Path) -> Verdict:
    """A report vouches for assets: it must list all of them with their hashes."""
    if not after.exists():
        return Verdict("false", "nothing vouches for the assets")
    known = json.loads(before.read_text(encoding="utf-8"))["assets"]
    try:
        found = json.loads(after.read_text(encoding="utf-8"))["assets"]
    except (ValueError, LookupError, TypeError):
        return Verdict("false", "the report cannot be read")
    if found != known:
        return Verdict("false", "other assets are vouched for")
    return Verdict("true", "it vouches for the same assets")


def check(folder: Path) -> tuple[str, tuple[str, ...], float]:
    """Return what ``plan check`` says of a folder, and how long it took in [s]."""
    begin = time.perf_counter()
    try:
        certificate = check_run(folder)
    except KinolabError as error:
        found: tuple[str, tuple[str, ...]] = REFUSED, (type(error).__name__,)
    except Exception as error:
        found = RAISED, (f"{type(error).__name__}: {error}",)
    else:
        failed = tuple(one.name for one in certificate.failures)
        found = (ACCEPTED if certificate.passed else REFUSED), failed
    return *found, time.perf_counter() - begin


def edited(
    folder: Path, other: Path, generator: Generator
) -> tuple[str, str, Verdict, tuple[str, tuple[str, ...], float]] | None:
    """Edit one file of a copy of a run, and have it checked; None where the edit does not apply.

    Returns:
        The edit's name, the file's, the judge's verdict and the verifier's answer.
    """
    edit = str(generator.choice(list(EDITS)))
    names = [name for name in names_in(folder) if name not in PICTURES]
    name = str(generator.choice(names))
    with tempfile.TemporaryDirectory() as made:
        copy = Path(made) / "run"
        shutil.copytree(folder, copy)
        if not EDITS[edit](copy, name, other, generator):
            return None
        return edit, name, judged(name, edit, folder, copy), check(copy)
