"""Good plans of every machine by several planners, made once and kept in a folder of runs."""

from __future__ import annotations

import json
import sys
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import kinolab
from kinolab.errors import InputError

# Searches by scenario: planners, and how many seeds each has. What is slow has fewer.
TREES = ("rrt_fast", "kpiece_fast", "auto", "sst")
SCENARIOS: dict[str, tuple[tuple[str, ...], int]] = {
    "rolling_disk_maze": ((*TREES, "rrt", "kpiece", "est", "potential_field"), 5),
    "pendulum_swingup": ((*TREES, "rrt", "kpiece", "shooting"), 5),
    "diffdrive_trap": ((*TREES, "potential_field", "shooting"), 4),
    "diffdrive_warehouse": (("auto", "kpiece_fast", "kinematic_first"), 3),
    "vehicle_parking": (("auto", "kpiece_fast", "kinematic_first"), 3),
    "five_bar_table": (("auto", "kpiece_fast", "rrt_fast", "shooting"), 4),
    "two_cranes": (("auto", "kpiece_fast", "shooting"), 4),
    "crane_factory": (("auto", "kpiece_fast", "shooting"), 3),
    "falling_disk_slalom": (("auto", "kpiece_fast", "rrt_fast"), 3),
    "motorcycle_chicane": (("auto", "kpiece_fast"), 3),
    "unicycle_slalom": (("kpiece_fast", "rrt_fast"), 3),
    "satellite_pointing": (("auto", "kpiece_fast", "shooting"), 4),
    "helicopter_canyon": (("auto", "kpiece_fast"), 3),
    "submarine_corridor": (("auto", "kpiece_fast"), 3),
    "snakeboard_park": (("auto", "kpiece_fast"), 3),
    "slip_steered_bay": (("kpiece_fast",), 3),
    "biped_walk": (("rrt_fast", "kpiece_fast"), 3),
    "marionette_stage": (("kpiece_fast",), 1),
}
LIMIT = {
    "marionette_stage": 85.0,
    "unicycle_slalom": 40.0,
    "slip_steered_bay": 40.0,
}  # [s] of a search; others have the next
SECONDS = 20.0
IMPROVED = 3  # every so many seeds the motion is improved, too, which leaves uneven steps
IMPROVING = 1.0  # [s] of work


@dataclass(frozen=True)
class Order:
    """One search: a scenario, a planner, a seed."""

    scenario: str
    planner: str
    seed: int

    def folder(self, plans: Path) -> Path:
        """Where its run is kept."""
        return plans / self.scenario / f"{self.planner}-{self.seed}"


def orders(scenarios: list[str]) -> list[Order]:
    """Return all searches of some scenarios, the first seeds of all first."""
    every = [
        Order(scenario, planner, seed)
        for scenario in scenarios
        for planner in SCENARIOS[scenario][0]
        for seed in range(1, SCENARIOS[scenario][1] + 1)
    ]
    return sorted(every, key=lambda one: one.seed)


def make(plans: Path, scenarios: list[str]) -> None:
    """Search for what is not in the folder yet; a search without a plan is noted there."""
    for order in orders(scenarios):
        folder = order.folder(plans)
        if (folder / "report.json").exists() or (folder / "none.json").exists():
            continue
        begin = time.monotonic()
        status = _searched(order, folder)
        spent = time.monotonic() - begin
        print(f"{folder}: {status}, {spent:.1f} s", file=sys.stderr, flush=True)


def _searched(order: Order, folder: Path) -> str:
    improve = IMPROVING if order.seed % IMPROVED == 0 else 0.0
    limit = LIMIT.get(order.scenario, SECONDS)
    try:
        problem = kinolab.load(order.scenario)
        plan = problem.solve(order.planner, order.seed, limit, improve=improve)
    except InputError as error:
        status, text = "refused", str(error)
    else:
        status, text = plan.status, plan.message
        if status == "solved":
            plan.save(folder)
            return status
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "none.json").write_text(json.dumps({"status": status, "message": text}))
    return status


def kept(plans: Path, scenarios: list[str]) -> Iterator[Path]:
    """Yield the folders of all plans that were found, in one order."""
    for scenario in scenarios:
        yield from sorted(report.parent for report in (plans / scenario).glob("*/report.json"))


def seed_of(*parts: object) -> int:
    """Return a seed for random numbers from what they are for, the same in every process."""
    return zlib.crc32("/".join(map(str, parts)).encode())
