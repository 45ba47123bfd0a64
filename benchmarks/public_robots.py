"""Robots that others described: which of their files are read, how fast, and whether rightly.

    python benchmarks/public_robots.py FOLDER ... [--compare 20] [--json FILE] [--before FILE]

Every FOLDER is a package: all of its URDF files, and all MJCF files that MuJoCo compiles, are read
as a user reads them; what MuJoCo itself refuses, mostly parts that other files include, is counted
apart. The root of a URDF file is fixed to the world, or moves freely where it has mass and two
chains of joints, or none, hang from it. With ``--compare N`` accelerations of what has N degrees of
freedom or fewer are compared with MuJoCo's or Pinocchio's, at random states under random inputs.
``--json`` keeps the rows; ``--before`` names what such rows of another version read rightly and
this one refuses.

It needs the extra ``test-all``.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).parents[1]))

SEED = 1
STATES = 5
AGREE = 1e-9  # relative to the largest acceleration
HEADINGS = ("package", "file", "read", "s", "degrees of freedom", "differs by")


@dataclass
class Row:
    """What became of one file.

    Attributes:
        package, file: Where it is.
        status: ``"read"``, ``"refused"``, ``"no model"``, or ``"out of time"``.
        reason: Why it is refused, or not compared.
        mistakes: How many reasons there are.
        seconds: To read it.
        freedom: How many velocities are independent.
        differs: From the second engine, relative to the largest acceleration.
    """

    package: str
    file: str
    status: str = "out of time"
    reason: str = ""
    mistakes: int = 0
    seconds: float = 0.0
    freedom: int = 0
    differs: float | None = None

    def __str__(self) -> str:
        said = self.status if self.status == "read" else f"{self.status}: {self.reason}"
        differs = self.reason or "–" if self.differs is None else f"{self.differs:.1e}"
        cells = (said, f"{self.seconds:.1f}", str(self.freedom), differs if said == "read" else "")
        return f"| {' | '.join((self.package, self.file, *cells)).replace(chr(10), ' ')} |"


def files_in(folder: Path) -> Iterator[Path]:
    """Yield the files of a package that may be robots."""
    for file in sorted(folder.rglob("*")):
        if file.suffix == ".urdf" or (file.suffix == ".xml" and b"<mujoco" in file.read_bytes()):
            yield file


def moves_freely(file: Path) -> bool:
    """Whether the root of a URDF file stands on several legs, or on none."""
    try:
        robot = ElementTree.parse(file).getroot()
    except ElementTree.ParseError:
        return False
    ends = {
        joint.find("child").get("link"): (joint.find("parent").get("link"), joint.get("type"))
        for joint in robot.findall("joint")
    }
    roots = [link for link in robot.findall("link") if link.get("name") not in ends]
    together, legs = {link.get("name") for link in roots}, 0
    while found := {child for child, (parent, _) in ends.items() if parent in together}:
        fixed = {child for child in found if ends[child][1] == "fixed"}
        legs += len(found - fixed)
        together = fixed
    return legs != 1 and any(link.find("inertial") is not None for link in roots)


def judged(file: Path, row: Row, most: int, pipe: Connection) -> None:
    """Send what becomes of a file, in a process of its own."""
    import logging

    from kinolab.dynamics.language.mechanism_parts import tangent_symbols
    from kinolab.errors import InputError
    from kinolab.robots import read_mjcf, read_urdf

    logging.disable()
    started = time.perf_counter()
    try:
        options = {"base": "floating"} if file.suffix == ".urdf" and moves_freely(file) else {}
        read = read_urdf if file.suffix == ".urdf" else read_mjcf
        system = read(file, **options)
        row.status, row.seconds = "read", time.perf_counter() - started
        row.freedom = len(tangent_symbols(system))
        row.reason = "out of time" if 0 < row.freedom <= most else "not compared"
        pipe.send(row)
        if 0 < row.freedom <= most:
            row.differs, row.reason = compared(file, options), ""
    except Exception as error:  # of MuJoCo's and Pinocchio's, too, it is a row of the table
        mistakes = error.mistakes if isinstance(error, InputError) else (error,)
        row.reason = " ".join(str(mistakes[0]).split())
        if row.status != "read":
            row.mistakes, row.seconds = len(mistakes), time.perf_counter() - started
            row.status = "no model" if "MuJoCo does not read it" in row.reason else "refused"
    pipe.send(row)


def compared(file: Path, options: dict[str, str]) -> float:
    """Return how far accelerations differ from a second engine's."""
    from kinolab.robots import read_mjcf, read_urdf

    if file.suffix == ".xml":
        from tests.robots import against_mujoco

        system = read_mjcf(file, shapes=False)
        if system.constraints:
            raise NotImplementedError("it has loops, which MuJoCo closes softly")
        return against_mujoco.difference(file, system, STATES, SEED)
    from tests.robots import against_pinocchio

    floating, system = bool(options), read_urdf(file, shapes=False, **options)
    return against_pinocchio.difference(file, system, STATES, SEED, floating=floating)


def row_of(package: Path, file: Path, most: int, limit: float) -> Row:
    """Return what becomes of a file within a limit of time in [s]."""
    row = Row(package.name, str(file.relative_to(package)))
    receiving, sending = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(
        target=judged, args=(file, row, most, sending)
    )
    process.start()
    sending.close()
    deadline = time.monotonic() + limit
    while receiving.poll(max(deadline - time.monotonic(), 0.0)):
        try:
            row = receiving.recv()
        except EOFError:
            break
    process.kill()
    process.join()
    return row


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--compare", type=int, default=0, help="up to so many degrees of freedom")
    parser.add_argument("--limit", type=float, default=60.0, help="[s] for each file")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--before", type=Path)
    given = parser.parse_args()
    import_module("kinolab.robots")  # once for all files
    rows: list[Row] = []
    print(f"| {' | '.join(HEADINGS)} |\n{'|---' * len(HEADINGS)}|")
    for folder in given.folders:
        for file in files_in(folder):
            rows.append(row_of(folder, file, given.compare, given.limit))
            if rows[-1].status != "no model":
                print(rows[-1], flush=True)
            if given.json:
                given.json.write_text(json.dumps([asdict(row) for row in rows], indent=1))
    print("\n| package | read | refused | no model | out of time | s | worst difference |")
    print("|---|---|---|---|---|---|---|")
    for package in dict.fromkeys(row.package for row in rows):
        own = [row for row in rows if row.package == package]
        count = Counter(row.status for row in own)
        statuses = (str(count[one]) for one in ("read", "refused", "no model", "out of time"))
        seconds = sum(row.seconds for row in own if row.status == "read")
        worst = max((row.differs for row in own if row.differs is not None), default=float("nan"))
        print(f"| {package} | {' | '.join(statuses)} | {seconds:.0f} | {worst:.1e} |")
    if given.before:
        now = {(row.package, row.file): row for row in rows}
        for entry in (Row(**fields) for fields in json.loads(given.before.read_text())):
            own = now.get((entry.package, entry.file))
            right = entry.status == "read" and (entry.differs or 0.0) <= AGREE
            if own is not None and right and own.status != "read":
                print(f"refused now: {own}")


if __name__ == "__main__":
    main()
