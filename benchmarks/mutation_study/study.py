"""A study in pieces: false plans, edited files and good plans, by number, in several processes."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache
from math import ceil
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from . import good, nested
from .attacks import KINDS, answer, made
from .cases import Cases
from .files import edited
from .judge import WALKS
from .plans import SCENARIOS, seed_of
from .records import Record

# Faults, edits and good plans of a scenario in a hundred; what takes long has fewer.
SHARES = {
    "marionette_stage": 0.5,
    "helicopter_canyon": 2,
    "submarine_corridor": 2,
    "slip_steered_bay": 2,
    "motorcycle_chicane": 3,
    "snakeboard_park": 2,
    "unicycle_slalom": 3,
    "diffdrive_warehouse": 4,
    "crane_factory": 5,
    "biped_walk": 5,
    "falling_disk_slalom": 6,
    "satellite_pointing": 6,
    "vehicle_parking": 8,
}
USUAL = 12
CHUNK = 40  # numbers of one scenario that a process works on


@dataclass(frozen=True)
class Chunk:
    """Numbers of one sort of a scenario's plans.

    Attributes:
        sort: ``false``, ``files``, ``good`` or ``nested``.
        scenario: Its name; requirements of nested terms have a machine of their own.
        numbers: They decide all that is drawn.
    """

    sort: str
    scenario: str
    numbers: tuple[int, ...]


def chunks(sort: str, count: int, scenarios: list[str], done: set[tuple[str, int]]) -> list[Chunk]:
    """Return what is to be done of a sort, in turns of the scenarios.

    Args:
        sort: Of plans.
        count: Of all plans together, about.
        scenarios: Their names.
        done: Scenario and number of what is done.
    """
    whole = sum(SHARES.get(name, USUAL) for name in scenarios)
    found: list[tuple[int, Chunk]] = []
    for name in scenarios:
        own = ceil(count * SHARES.get(name, USUAL) / whole)
        left = [n for n in range(own) if (name, n) not in done]
        pieces = [tuple(left[at : at + CHUNK]) for at in range(0, len(left), CHUNK)]
        found += [(turn, Chunk(sort, name, piece)) for turn, piece in enumerate(pieces)]
    return [chunk for _, chunk in sorted(found, key=lambda pair: pair[0])]


@cache
def _cases(plans: Path) -> Cases:
    return Cases(plans)


def worked(plans: Path, seed: int, chunk: Chunk) -> list[Record]:
    """Work on a chunk in this process."""
    make = {"false": _false, "files": _files, "good": _good, "nested": _nested}[chunk.sort]
    cases = _cases(plans)
    found = [make(cases, chunk.scenario, seed, number) for number in chunk.numbers]
    return [record for record in found if record is not None]


def _false(cases: Cases, scenario: str, seed: int, number: int) -> Record | None:
    """Make the false plan of a number: kinds that the machine can have take turns."""
    kinds = _kinds_of(cases, scenario)
    if not kinds:
        return None
    kind = kinds[number % len(kinds)]
    return made(cases, scenario, kind, seed_of(seed, scenario, number), number)


def _kinds_of(cases: Cases, scenario: str) -> list[str]:
    """Return the kinds of fault that a scenario's machine can have."""
    folders = cases.of(scenario)
    if not folders:
        return []
    case = cases.read(folders[0])
    judge, name = case.judge, case.problem.machine.name
    cannot = {
        "reference": not case.motion.reference_names,
        "gain": judge.law is None or not judge.knows,
        "quaternion": not judge.attitudes,
        "mode skipped": name not in WALKS,
        "parameter": name in WALKS or not judge.knows,
        "limit passed": name in WALKS or not judge.knows,
        "workspace left": name in WALKS or not judge.knows,
        "string in compression": name != "two_cranes",
        "own parts touch": name != "two_cranes",
        "obstacle": not case.problem.world.obstacles,
    }
    return [kind for kind in KINDS if not cannot.get(kind, False)]


def _files(cases: Cases, scenario: str, seed: int, number: int) -> Record | None:
    """Edit a file of one of a scenario's runs."""
    folders = cases.of(scenario)
    if len(folders) < 2:
        return None
    generator = np.random.default_rng(seed_of(seed, scenario, "files", number))
    one, other = generator.choice(len(folders), 2, replace=False)
    found = edited(folders[one], folders[other], generator)
    if found is None:
        return None
    edit, name, verdict, (said, failed, seconds) = found
    machine = cases.read(folders[one]).problem.machine.name
    plan = f"{scenario}/{folders[one].name}"
    why = (name, verdict.truth, verdict.why)
    return Record(number, machine, edit, plan, *why, said, failed, round(seconds, 4))


def _good(cases: Cases, scenario: str, seed: int, number: int) -> Record | None:
    """Put a good plan before the verifier: the first ones as they were found."""
    folders, kinds = cases.of(scenario), list(good.KINDS)
    if not folders:
        return None
    generator = np.random.default_rng(seed_of(seed, scenario, "good", number))
    if number < len(folders):
        case, kind = cases.read(folders[number]), kinds[0]
    else:
        case = cases.read(folders[int(generator.integers(len(folders)))])
        kind = kinds[1 + number % (len(kinds) - 1)]
    plan = good.KINDS[kind](case, generator)
    if plan is None:
        return None
    said, failed, seconds = answer(plan.problem, plan.motion)
    machine, verdict = plan.problem.machine.name, plan.verdict
    why = (plan.what, verdict.truth, verdict.why)
    return Record(number, machine, kind, case.name, *why, said, failed, round(seconds, 4))


def _nested(_cases: Cases, scenario: str, seed: int, number: int) -> Record:
    """Put a requirement of nested terms before the verifier: broken and kept ones take turns."""
    fault = nested.requirement(seed, number)
    said, failed, seconds = answer(fault.problem, fault.motion)
    why = (fault.what, fault.verdict.truth, fault.verdict.why)
    kind, machine = "requirement of nested terms", fault.problem.machine.name
    return Record(number, machine, kind, scenario, *why, said, failed, round(seconds, 4))


def results(
    plans: Path, seed: int, work: list[Chunk], jobs: int
) -> Iterator[tuple[Chunk, list[Record]]]:
    """Yield what came of each chunk, as it is done."""
    if jobs == 1:
        for chunk in work:
            yield chunk, worked(plans, seed, chunk)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(worked, plans, seed, chunk): chunk for chunk in work}
        try:
            for future in as_completed(waiting):
                yield waiting[future], future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def known_scenarios() -> list[str]:
    """Return the names of all scenarios that plans are made of."""
    return list(SCENARIOS)
