"""Mutants of kinolab: does the default set of tests notice that one statement is wrong?

    python benchmarks/mutants.py [--seed 60] [--each 6] [--list] [--only 3,17] [--out mutants]

Statements are drawn at random from all of a part's, and one of their places is changed: a sign, a
comparison, a check that is dropped, a tolerance that becomes ten times as large, a column that is
exchanged for another one. Tests run until one fails, those nearest to the module first: the default
set, and on what survives that, all others (`-m "not long"`, with the extra `test-all`) whose files
import the module or its package. Mutants that no test can notice are named with their reason in
`EQUIVALENT`, and others are drawn in their place.

Each mutant is a copy of the package in a folder of its own, with caches of its own: loops are
compiled anew if the module has loops or constants that loops may have read. It needs the extra
`test`, prints a Markdown table, and keeps what it found in OUT, so that it may be ended and started
again.
"""

from __future__ import annotations

import argparse
import ast
import itertools
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "kinolab"
PARTS = ("dynamics", "search", "trajopt", "verification", "show")
FLIPPED = {
    "<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "!=", "!=": "==",
    "is": "is not", "is not": "is", "in": "not in", "not in": "in",
}  # fmt: skip
SIGNS = {"+": "-", "-": "+"}
SMALL = 1e-2  # a number up to this one is taken for a tolerance
OTHERS = "(search or process or docs or every) and not long"  # which do not run by default
PATIENCE = 4.0  # times as long as without a mutant: then it loops for ever
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.M)

# Mutants that change nothing anybody can observe, by module, line as it was and as it became.
EQUIVALENT: dict[tuple[str, str], str] = {
    (
        "trajopt/nlp/collision_constraints.py",
        "remember(s, room if count == first else -math.inf, around, found)",
    ): "either way states near the last one are never taken to be far where they are not: what is"
    " remembered then only saves time",
    (
        "dynamics/analysis/consistent_states.py",
        'options={"ftol": 1e-14, "maxiter": 200},',
    ): "where SLSQP ends by either, Newton's steps lead on onto the constraints, to rounding",
    (
        "show/film/staging/stage.py",
        "floor = np.maximum(near, np.float32(1e-12))",
    ): "nothing is drawn nearer than a picometre: both only keep 0 from being divided by",
    (
        "show/scene/camera.py",
        "seen = np.where(np.abs(seen) < 1e-12, 0.0, seen)",
    ): "either is far below a pixel: what counts as 0 is what rounding has left of it",
}


@dataclass(frozen=True)
class Mutant:
    """One change of one line.

    Attributes:
        module: Path below the package.
        line: Its number, from 1.
        kind: Sign, comparison, check, tolerance or column.
        before: The line as it is.
        after: The line as it becomes; several where a check is dropped.
        lines: How many lines are replaced.
    """

    module: str
    line: int
    kind: str
    before: str
    after: str
    lines: int = 1

    @property
    def name(self) -> str:
        """Return what it is called in tables."""
        return f"{self.module}:{self.line}"

    @cached_property
    def compiled(self) -> bool:
        """Whether loops may have been compiled from what it changes."""
        text = (PACKAGE / self.module).read_text(encoding="utf-8")
        return "kernel" in text or "llvm" in text or not self.before.startswith(" ")


def mutants_of(path: Path) -> Iterator[list[Mutant]]:
    """Yield the mutants of each statement of a module that has some."""
    text = path.read_text(encoding="utf-8")
    lines, module = text.splitlines(), str(path.relative_to(PACKAGE))
    for statement in ast.walk(ast.parse(text)):
        if isinstance(statement, ast.stmt) and not _declares(statement):
            found = [*_in_statement(statement, lines, module), *_dropped(statement, lines, module)]
            if found:
                yield found


def _declares(statement: ast.stmt) -> bool:
    """Whether a statement is a docstring, an import or a definition, whose body has statements."""
    declared = ast.Import | ast.ImportFrom | ast.FunctionDef | ast.ClassDef
    text = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
    return isinstance(statement, declared) or text


def _expressions(statement: ast.stmt) -> Iterator[ast.expr]:
    """Yield the expressions of a statement that belong to no statement inside it."""
    open_nodes = [n for n in ast.iter_child_nodes(statement) if not isinstance(n, ast.stmt)]
    while open_nodes:
        node = open_nodes.pop()
        open_nodes += [n for n in ast.iter_child_nodes(node) if not isinstance(n, ast.stmt)]
        if isinstance(node, ast.expr):
            yield node


def _in_statement(statement: ast.stmt, lines: list[str], module: str) -> Iterator[Mutant]:
    annotation = getattr(statement, "annotation", None)
    hidden = set(ast.walk(annotation)) if annotation else set()
    for node in _expressions(statement):
        if node in hidden or node.lineno != node.end_lineno:
            continue
        row, line = node.lineno, lines[node.lineno - 1]
        for kind, first, last, new in _changes(node, line):
            after = line[:first] + new + line[last:]
            yield Mutant(module, row, kind, line, after)


def _changes(node: ast.expr, line: str) -> Iterator[tuple[str, int, int, str]]:
    """Yield kinds of changes: from which to which column of the line, and what stands there."""
    at = _columns(line)
    match node:
        case ast.BinOp(left, ast.Add() | ast.Sub(), right):
            first, last = at(left.end_col_offset), at(right.col_offset)
            sign = re.search(r"[+-]", line[first:last])
            if sign:
                k = first + sign.start()
                yield "sign", k, k + 1, SIGNS[line[k]]
        case ast.UnaryOp(ast.USub(), _):
            yield "sign", at(node.col_offset), at(node.col_offset) + 1, ""
        case ast.Compare(left, [_], [right]):
            first, last = at(left.end_col_offset or 0), at(right.col_offset)
            operator = line[first:last].strip(" ()")
            if operator in FLIPPED:
                k = line.index(operator, first)
                yield "comparison", k, k + len(operator), FLIPPED[operator]
        case ast.Constant(float() as value) if 0.0 < abs(value) <= SMALL:
            yield "tolerance", at(node.col_offset), at(node.end_col_offset), f"{10 * value:g}"
        case ast.Subscript(_, ast.Constant(int() as k)):
            inner = node.slice
            yield "column", at(inner.col_offset), at(inner.end_col_offset), str(k - 1 if k else 1)
        case ast.Subscript(_, ast.Tuple(entries)):
            for entry in entries:
                if isinstance(entry, ast.Constant) and isinstance(entry.value, int):
                    new = str(entry.value - 1 if entry.value else 1)
                    yield "column", at(entry.col_offset), at(entry.end_col_offset), new


def _columns(line: str):  # type: ignore[no-untyped-def]
    """Return what turns an offset in bytes, as Python's parser has it, into one in characters."""
    encoded = line.encode()
    return lambda offset: len(encoded[: offset or 0].decode())


def _dropped(statement: ast.stmt, lines: list[str], module: str) -> Iterator[Mutant]:
    """Yield an ``if`` that is left out because all it does is raise, return or go on."""
    leaving = ast.Raise | ast.Return | ast.Continue | ast.Break
    if not isinstance(statement, ast.If) or statement.orelse:
        return
    if len(statement.body) == 1 and isinstance(statement.body[0], leaving):
        row, count = statement.lineno, (statement.end_lineno or 0) - statement.lineno + 1
        before = lines[row - 1]
        if before.lstrip().startswith("if "):
            indent = before[: len(before) - len(before.lstrip())]
            yield Mutant(module, row, "check", before, f"{indent}pass", count)


def drawn(part: str, each: int, seed: int) -> list[Mutant]:
    """Return mutants of a part: statements at random, and one change of each."""
    generator = random.Random(f"{seed} {part}")
    statements = [
        found for path in sorted((PACKAGE / part).rglob("*.py")) for found in mutants_of(path)
    ]
    generator.shuffle(statements)
    chosen: list[Mutant] = []
    for found in statements:
        mutant = generator.choice(found)
        if len(chosen) < each and (mutant.module, mutant.before.strip()) not in EQUIVALENT:
            chosen.append(mutant)
    return chosen


def planted(mutant: Mutant, sound: Path, place: Path) -> Path:
    """Return a folder from which Python imports a mutant, with the caches of the sound package."""
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(sound, place, symlinks=True)
    file = place / "kinolab" / mutant.module
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    k = mutant.line - 1
    lines[k : k + mutant.lines] = [mutant.after + "\n"]
    file.write_text("".join(lines), encoding="utf-8")
    if mutant.compiled:
        for path in [*place.rglob("*.nbi"), *place.rglob("*.nbc")]:
            path.unlink()
    return place


def package_in(place: Path) -> Path:
    """Copy the package, its planners and its scenarios into a folder, as they are installed."""
    if not place.exists():
        shutil.copytree(PACKAGE, place / "kinolab")
        for name in ("planners", "scenarios"):
            shutil.copytree(ROOT / name, place / "kinolab" / name)
    return place


def nearest_first(module: str) -> list[list[str]]:
    """Return files of tests, those nearest to a module first: of its own part, and all others."""
    parts = Path(module).with_suffix("").parts

    def distance(file: Path) -> tuple[int, int, str]:
        own = file.relative_to(ROOT / "tests").with_suffix("").parts
        pairs = zip(parts[:-1], own[:-1], strict=False)
        common = len(list(itertools.takewhile(lambda pair: pair[0] == pair[1], pairs)))
        return -common, parts[-1] not in own[-1], str(file)

    files = sorted((ROOT / "tests").rglob("test_*.py"), key=distance)
    near = sum(distance(file)[0] < 0 for file in files)
    names = [str(file.relative_to(ROOT)) for file in files]
    return [names[:near], names[near:]]


def importing(module: str, files: list[str]) -> list[str]:
    """Return the files of tests that name a module or the package that it is in."""
    names = module.removesuffix(".py").split("/")
    wanted = (".".join(["kinolab", *names]), ".".join(["kinolab", *names[:-1]]))
    found = []
    for file in files:
        text = (ROOT / file).read_text(encoding="utf-8")
        if any(re.search(rf"\b{re.escape(name)}\b", text) for name in wanted):
            found.append(file)
    return found or files


def noticed(place: Path, files: list[str], limit: float | None, *options: str) -> str:
    """Return the first test that fails within a limit in [s], "" if none does."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(place),
        "KINOLAB_CACHE": str(place / "cache"),
        "PYTEST_XDIST_AUTO_NUM_WORKERS": str(os.cpu_count() or 1),
    }
    command = [
        *(sys.executable, "-m", "pytest", "-x", "-q"),
        *("--dist", "load", "--maxschedchunk", "1", *options, *files),
    ]
    running = subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, start_new_session=True,
    )  # fmt: skip
    try:
        said, _ = running.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        return f"not done after {limit:.0f} s"
    finally:
        with suppress(ProcessLookupError):  # its workers may be in a loop without an end
            os.killpg(running.pid, signal.SIGKILL)
        running.wait()
    if running.returncode in (0, 5):
        return ""
    failed = FAILED.search(said)
    return failed[1] if failed else f"exit code {running.returncode}: {said[-300:]}"


def main() -> None:
    """Run the tests on each mutant that has no result yet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=60)
    parser.add_argument("--each", type=int, default=6)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=Path, default=Path("mutants"))
    given = parser.parse_args()
    all_drawn = [m for part in PARTS for m in drawn(part, given.each, given.seed)]
    wanted = {int(k) for k in given.only.split(",") if k} or set(range(len(all_drawn)))
    if given.list:
        for k, mutant in enumerate(all_drawn):
            print(f"{k}: {mutant.name} ({mutant.kind})\n  - {mutant.before.strip()}")
            print(f"  + {mutant.after.strip()}")
        return
    given.out.mkdir(parents=True, exist_ok=True)
    out = given.out.resolve()
    sound = package_in(out / "sound")
    warm = out / "warm"
    if not warm.exists():  # and no test may fail without a mutant
        begun = time.monotonic()
        failed = noticed(sound, ["tests"], None)
        if failed:
            sys.exit(f"without a mutant: {failed}")
        warm.write_text(f"{time.monotonic() - begun:.0f}")
    limit = PATIENCE * float(warm.read_text())
    kept = out / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {}
    for k, mutant in enumerate(all_drawn):
        key = f"{mutant.name} {mutant.after.strip()}"
        if k not in wanted or key in results:
            continue
        place = planted(mutant, sound, out / "mutant")
        near, far = nearest_first(mutant.module)
        first = noticed(place, near, limit) or noticed(place, far, limit)
        rest = importing(mutant.module, [*near, *far])
        then = "" if first else noticed(place, rest, PATIENCE * limit, "-m", OTHERS)
        results[key] = [first, then]
        kept.write_text(json.dumps(results, indent=1) + "\n")
        print(f"{k}: {mutant.name}: {first or then or 'survives'}", file=sys.stderr, flush=True)
    print(
        "| mutant | kind | before | after | noticed by | default set |\n|---|---|---|---|---|---|"
    )
    for mutant in all_drawn:
        first, then = results.get(f"{mutant.name} {mutant.after.strip()}", ["?", "?"])
        row = (
            *(f"`{mutant.name}`", mutant.kind, f"`{mutant.before.strip()}`"),
            *(
                f"`{mutant.after.strip()}`",
                first or then or "**nothing**",
                "yes" if first else "no",
            ),
        )
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
