"""The attacks: false plans by number, put before the verifier."""

from __future__ import annotations

import time

import numpy as np

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

from . import faults, machines, worlds
from .cases import Cases
from .faults import Kind
from .records import ACCEPTED, RAISED, REFUSED, Record

KINDS: dict[str, Kind] = {**faults.KINDS, **worlds.KINDS, **machines.KINDS}

FEW = 5  # plans that goals are moved for, as the judge follows these from their start to their end


def answer(problem: PlanningTask, motion: Trajectory) -> tuple[str, tuple[str, ...], float]:
    """Return the verifier's answer, the checks that failed, and how long it took in [s]."""
    begin = time.perf_counter()
    try:
        certificate = verify(problem, motion)
    except KinolabError as error:  # a refusal in words
        found: tuple[str, tuple[str, ...]] = REFUSED, (f"{type(error).__name__}: {error}",)
    except Exception as error:  # what a verifier may never do
        found = RAISED, (f"{type(error).__name__}: {error}",)
    else:
        failed = tuple(check.name for check in certificate.failures)
        found = (ACCEPTED if certificate.passed else REFUSED), failed
    return *found, time.perf_counter() - begin


def made(cases: Cases, scenario: str, kind: str, seed: int, number: int) -> Record | None:
    """Make one false plan of a kind from a scenario's plans, and have it verified."""
    folders = cases.of(scenario)
    if not folders:
        return None
    generator = np.random.default_rng(seed)
    if kind == "goal":
        folders = folders[:FEW]
    case = cases.read(folders[int(generator.integers(len(folders)))])
    fault = KINDS[kind](case, generator)
    if fault is None:
        return None
    said, failed, seconds = answer(fault.problem, fault.motion)
    machine, verdict = fault.problem.machine.name, fault.verdict
    why = (fault.what, verdict.truth, verdict.why)
    return Record(number, machine, kind, case.name, *why, said, failed, round(seconds, 4))
