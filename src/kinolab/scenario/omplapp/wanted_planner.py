"""Which of kinolab's planners a problem file means."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from kinolab.scenario.omplapp.cfg_text import CfgFile, CfgValue

# OMPL.app's names of planners that kinolab has, too.
SAME = {
    "rrt": "rrt",
    "est": "est",
    "kpiece": "kpiece",
    "pdst": "pdst",
    "sst": "sst",
    "sycloprrt": "syclop_rrt",
    "syclopest": "syclop_est",
}
_TREES = ("rrtconnect", "lazyrrt", "trrt", "biest", "projest", "sbl", "bkpiece", "lbkpiece")
# kinolab's prm and prm_geometric found nothing in 30 s for such machines where its trees took 3.
_ROADMAPS = ("prm", "lazyprm", "spars", "spars2")
_OPTIMAL = (
    *("rrtstar", "rrtxstatic", "lbtrrt", "lazylbtrrt", "prmstar", "lazyprmstar", "fmt", "bfmt"),
    *("bitstar", "abitstar", "aitstar", "anytimepathshortening", "aps", "cforest"),
)
# What works instead, for those that kinolab does not have.
INSTEAD = {
    **dict.fromkeys((*_TREES, "stride", *_ROADMAPS), "kpiece_fast"),
    **dict.fromkeys(_OPTIMAL, "ao_rrt"),
}
GOAL_BIAS = "goal_bias"  # the one setting that means the same in OMPL's planners and kinolab's


@dataclass(frozen=True)
class WantedPlanner:
    """The planner of a scenario, and what is to be said of it.

    Attributes:
        keys: Of ``[planner]``; empty where kinolab chooses.
        notes: Sentences on what the file says and kinolab does not do.
    """

    keys: dict[str, Any]
    notes: tuple[str, ...]


def wanted_planner(file: CfgFile) -> WantedPlanner:
    """Return what ``[planner]`` of a file asks for; what is no planner is a mistake.

    One planner that kinolab has is taken. A file that compares several is planned with kinolab's
    own choice.
    """
    named: dict[str, dict[str, CfgValue]] = {}
    for value in file.sections.get("planner", []):
        name, _, setting = value.key.lower().partition(".")
        # what begins so is said of samplers and projections, not of a planner
        if value.key.lower().startswith("problem."):
            continue
        if file.chosen(CfgValue(value.key, name, value.line), "planner", {**SAME, **INSTEAD}):
            settings = named.setdefault(name, {})
            if setting:
                settings[setting] = value
    (only,) = named if len(named) == 1 else ("",)
    if only not in SAME:
        return WantedPlanner({}, tuple(_told(list(named))))
    keys: dict[str, Any] = {"name": SAME[only]}
    unused = [setting for setting in named[only] if setting not in (GOAL_BIAS, "name")]
    if GOAL_BIAS in named[only]:
        if SAME[only] in ("rrt", "est", "kpiece", "sst"):
            share = file.number(named[only][GOAL_BIAS])
            if share is not None and not 0.0 <= share <= 1.0:
                what = f"{share:g} is no probability."
                file.wrong(named[only][GOAL_BIAS], what, "Give a number from 0 to 1.")
            keys[GOAL_BIAS] = share or 0.0
        else:
            unused.append(GOAL_BIAS)
    notes = [f"{SAME[only]} has no setting {', '.join(unused)}."] if unused else []
    return WantedPlanner(keys, tuple(notes))


def _told(named: list[str]) -> Iterator[str]:
    """Yield what a file that names no planner or several should know."""
    here = [SAME[name] for name in named if name in SAME]
    absent = {name: INSTEAD[name] for name in named if name in INSTEAD}
    if absent:
        instead = [*dict.fromkeys(absent.values())]
        works = "works" if len(instead) == 1 else "work"
        yield f"kinolab has no {', '.join(absent)} here; {', '.join(instead)} {works} instead."
    if len(named) > 1:
        known = f"kinolab has {', '.join(here)}. " if here else ""
        yield f"The file compares planners. {known}--planner NAME takes one of them."
