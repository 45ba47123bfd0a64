"""False plans for the verifier to refuse, and good ones to accept, judged by others.

    python benchmarks/mutations.py --plans DIR [--make] [--results DIR] [--faults 10000]
                                   [--edits 1000] [--good 1000] [--nested 2000]
                                   [--scenarios NAME,…] [--seed 1] [--jobs N] [--print]

``--make`` searches for plans of all machines of the gallery, and keeps them in ``--plans`` as
folders of runs. The study then draws random faults in them: states, inputs, times and quaternions
changed by 1e-4 to 1 of their scale, rows dropped, doubled and swapped, goals missed by 1.01
tolerances, obstacles moved into the way by the distance and a millimetre, walls of a millimetre
between two rows, parameters and gains off by 1 %, modes skipped, limits passed between rows, a rope
that pushes, requirements of nested terms that a narrow place breaks, edited files. Whether a plan
is false then is decided without kinolab: by the fault's size, or by equations of motion written by
hand (``tests/oracles``) and SciPy's integrator, or by closed forms of bodies. As many good plans
must be accepted, whole turns and signs included. ``--nested`` requirements of max, min, abs, sign,
exp and products, with features of 1e-9 to 0.1 m, are broken at a place and must be refused, and as
many are just met there, or better, and must be accepted; they need no plans.

Records are appended to files in ``--results``; started again, it goes on with what is missing. It
prints Markdown tables and writes them and a JSON summary there. Returns 1 if anything false was
accepted or anything good refused.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))  # the oracles are in its folder of tests

from gallery import describe  # noqa: E402
from mutation_study.plans import make  # noqa: E402
from mutation_study.records import Record, append, read  # noqa: E402
from mutation_study.study import chunks, known_scenarios, results  # noqa: E402
from mutation_study.tables import as_json, let_in, text, wrong  # noqa: E402

SORTS = ("false", "files", "good", "nested")
INTERRUPTED = 130


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="False plans for the verifier to refuse.")
    parser.add_argument("--plans", type=Path, required=True, metavar="DIR", help="of good plans")
    parser.add_argument("--make", action="store_true", help="search for plans that are missing")
    parser.add_argument("--results", type=Path, default=Path("mutations"), metavar="DIR")
    parser.add_argument("--faults", type=int, default=10_000, metavar="N")
    parser.add_argument("--edits", type=int, default=1000, metavar="N", help="of files")
    parser.add_argument("--good", type=int, default=1000, metavar="N")
    parser.add_argument("--nested", type=int, default=2000, metavar="N", help="and as many true")
    parser.add_argument("--scenarios", metavar="NAME,…", help="default: all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes")
    parser.add_argument("--print", action="store_true", help="only print what is there")
    options = parser.parse_args()
    known = known_scenarios()
    options.scenarios = options.scenarios.split(",") if options.scenarios else known
    if unknown := [name for name in options.scenarios if name not in known]:
        parser.error(f"unknown: {', '.join(unknown)}. Known: {', '.join(known)}.")
    if options.jobs < 1:
        parser.error("--jobs must be positive")
    return options


def place(options: argparse.Namespace, sort: str) -> Path:
    """Return the file of a sort's records."""
    return Path(options.results) / f"{sort}.jsonl"


def attack(options: argparse.Namespace) -> None:
    """Make what is missing of each sort, and write it as it comes."""
    options.results.mkdir(parents=True, exist_ok=True)
    counts = (options.faults, options.edits, options.good, 2 * options.nested)
    for sort, count in zip(SORTS, counts, strict=True):
        file = place(options, sort)
        done = {(record.plan.partition("/")[0], record.number) for record in read(file)}
        work = chunks(sort, count, [sort] if sort == "nested" else options.scenarios, done)
        for number, (chunk, found) in enumerate(
            results(options.plans, options.seed, work, options.jobs), start=1
        ):
            append(file, found)
            told = f"{sort}: {number} of {len(work)}, {chunk.scenario}"
            print("\n".join([told, *complaints(sort, found)]), file=sys.stderr, flush=True)


def complaints(sort: str, found: list[Record]) -> list[str]:
    """Return what went wrong in some records, in lines."""
    if sort == "good":
        return wrong([], found)
    return wrong(let_in(found) if sort == "files" else found, [])


def main() -> int:
    """Print the tables; return 1 if the verifier erred, 130 if it was interrupted."""
    options, interrupted = arguments(), False
    try:
        if options.make and not options.print:
            make(options.plans, options.scenarios)
        if not options.print:
            attack(options)
    except KeyboardInterrupt:
        interrupted = True
    false, files, good, nested = (read(place(options, sort)) for sort in SORTS)
    false += nested
    tables = f"{describe()}\n\n{text(false, good, files)}"
    print(tables)
    if not options.print:
        (options.results / "tables.md").write_text(tables, encoding="utf-8")
        (options.results / "summary.json").write_text(as_json(false, good, files))
    if interrupted:
        return INTERRUPTED
    return int(bool(wrong([*false, *let_in(files)], good)))


if __name__ == "__main__":
    sys.exit(main())
