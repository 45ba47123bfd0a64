"""Rules that join several keys of a scenario.

They work on what the user gave, so that they also speak up where some other key is wrong.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal, get_args

from kinolab.dynamics.codegen.methods import METHODS, Method, add_method
from kinolab.errors import InputError, unknown_name
from kinolab.scenario.issues import Issue, KeyPath
from kinolab.scenario.toml_text import shortened, string_text
from kinolab.scenario.values import ROBOT_ONLY

ObstacleKind = Literal["mesh", "box", "sphere", "cylinder", "capsule", "map", "cloud", "run"]
OBSTACLE_KINDS: tuple[ObstacleKind, ...] = get_args(ObstacleKind)
KINDS_OF = {  # which kinds of obstacles have a key that not all have
    **{"scale": ("mesh", "cloud"), "up": ("mesh", "cloud")},
    **dict.fromkeys(("solid", "simplify"), ("mesh",)),
    **dict.fromkeys(("resolution", "height", "unknown", "relief", "max_slope"), ("map",)),
    **dict.fromkeys(("radius", "voxel"), ("cloud",)),
}
PLURAL = {"mesh": "meshes", "map": "maps", "cloud": "clouds"}
MOTION_WAYS = {  # of saying how an obstacle moves, by the keys of each
    **{"velocity": "velocity and spin", "spin": "velocity and spin"},
    **{"position": "position and rpy", "rpy": "position and rpy"},
    **{"points": "points", "file": "file"},
}
POSE_OF_MOTION = {"position": ("points", "file", "position"), "rpy": ("rpy",)}
PLANNER_KEYS = ("name", "time_limit", "max_iterations", "seed", "improve")


def document_issues(document: Mapping[str, object]) -> list[Issue]:
    """Apply every rule to a document of which nothing is known yet."""
    system, world, planner, integration, objective = (
        _table(document.get(key))
        for key in ("system", "world", "planner", "integration", "objective")
    )
    entries = world.get("obstacle")
    obstacles = [_table(entry) for entry in entries] if isinstance(entries, list) else []
    motions = {k: _table(one["motion"]) for k, one in enumerate(obstacles) if "motion" in one}
    via = document.get("via")
    goals: dict[KeyPath, object] = {("goal",): document.get("goal")}
    goals |= {("via", k): one for k, one in enumerate(via if isinstance(via, list) else [])}
    found: list[tuple[KeyPath, list[Issue]]] = [
        (("system",), system_issues(system, system.get("file")) if "system" in document else []),
        *(
            (("world", "obstacle", k), obstacle_issues(one, motions.get(k, ())))
            for k, one in enumerate(obstacles)
        ),
        *((("world", "obstacle", k, "motion"), motion_issues(one)) for k, one in motions.items()),
        (("world", "obstacle"), name_issues([one.get("name") for one in obstacles])),
        (
            ("objective",),
            objective_issues(objective) if isinstance(document.get("objective"), dict) else [],
        ),
        *((at, region_issues(one)) for at, one in _regions(goals)),
        (("integration",), integration_issues(integration)),
        (("planner",), planner_issues(planner)),
    ]
    return [
        replace(issue, path=prefix + issue.path) for prefix, issues in found for issue in issues
    ]


def objective_issues(given: Mapping[str, object]) -> list[Issue]:
    """Something costs, and a motion that costs less the longer it takes has an end."""
    weights = {key: value for key, value in given.items() if key != "max_time"}
    costs = [
        key
        for key, value in weights.items()
        if (any(value.values()) if isinstance(value, Mapping) else bool(value))
    ]
    if not costs:
        return [Issue((), "nothing costs anything.", "Write time = 1.0, or effort = 1.0.")]
    if costs == ["effort"] and "max_time" not in given:
        what = "effort alone becomes less the longer a motion takes, without end."
        return [Issue(("effort",), what, "Write max_time = 10.0 [s], or time = 0.1, too.")]
    return []


def _regions(goals: Mapping[KeyPath, object]) -> Iterator[tuple[KeyPath, Mapping[str, object]]]:
    """Yield the regions of goals, and of those of which any will do, with their places."""
    for at, goal in goals.items():
        for key in ("region", "any_of"):
            rows = _table(goal).get(key)
            placed = {
                (*at, key, k): row for k, row in enumerate(rows if isinstance(rows, list) else [])
            }
            if key == "any_of":
                yield from _regions(placed)
            else:
                yield from ((place, _table(row)) for place, row in placed.items())


def region_issues(given: Mapping[str, object]) -> list[Issue]:
    """A region has a limit, and room between two."""
    least, most = given.get("least"), given.get("most")
    if least is None and most is None:
        return [Issue((), "nothing limits its formula.", "Write least = 1.0, or most = 2.0.")]
    if isinstance(least, int | float) and isinstance(most, int | float) and not least < most:
        return [Issue(("most",), f"{most:g} is not above least, {least:g}.", "Exchange them.")]
    return []


def system_issues(given: Mapping[str, object], file: object) -> list[Issue]:
    """A machine has one description, and only a robot's file leaves base and joints open."""
    if "machines" in given:  # of [[machine]] entries, each of which is held against this
        return []
    issues = _exactly_one(
        list(given), ("name", "file"), "a registered machine's name or a machine's file"
    )
    named = file if isinstance(file, str) else ""
    for key, formats, kind in ROBOT_ONLY:
        if key in given and not named.endswith(formats):
            issues.append(Issue((key,), f"{key} is a key of {kind} only.", f"Leave {key} out."))
    if not given.get("kinematic"):
        remedy = "Write kinematic = true, too, or leave it out."
        issues += [
            Issue((key,), f"{key} is a limit of kinematic robots.", remedy)
            for key in ("max_velocity", "max_acceleration")
            if key in given
        ]
    elif "density" in given:
        what = "masses have no part in the motion of a kinematic robot."
        issues.append(Issue(("density",), what, "Leave density or kinematic out."))
    return issues


def obstacle_issues(given: Mapping[str, object], motion: Iterable[str] = ()) -> list[Issue]:
    """An obstacle has one shape and pose, and keys of its kind; what sensors see stays there.

    Args:
        given: What its keys are set to.
        motion: The keys of its motion.
    """
    motion = list(motion)
    issues = _exactly_one(list(given), OBSTACLE_KINDS, "one shape per obstacle")
    for key, kinds in KINDS_OF.items():
        if key in given and not {*kinds} & {*given}:
            of = " and ".join(PLURAL[kind] for kind in kinds)
            issues.append(Issue((key,), f"{key} is a key of {of} only.", f"Leave {key} out."))
    sensed = next((kind for kind in ("map", "cloud") if kind in given), None)
    if sensed and "motion" in given:
        what = f"{PLURAL[sensed]} do not move."
        issues.append(Issue(("motion",), what, "Let boxes or meshes move."))
    if "run" in given and "motion" in given:
        what = "the machine of another plan moves as was planned there."
        issues.append(Issue(("motion",), what, "Leave motion out."))
    for key in ("position", "rpy"):
        instead = [way for way in POSE_OF_MOTION[key] if way in motion]
        if _not_zero(given.get(key)) and instead:
            what = f"{key} is not used, because motion.{instead[0]} says where the obstacle is."
            issues.append(Issue((key,), what, f"Leave {key} out."))
    if "cloud" in given and "radius" not in given:
        remedy = "Write radius = 0.03 [m], about the distance of its points."
        issues.append(Issue((), "the points of a cloud have no radius.", remedy))
    if "max_slope" in given and "relief" not in given:
        what = "max_slope is a limit of heights, and nothing says how high white is."
        issues.append(Issue(("max_slope",), what, "Write relief = 5.0 [m], too."))
    return issues


def _not_zero(numbers: object) -> bool:
    return isinstance(numbers, list | tuple) and any(number != 0 for number in numbers)


def motion_issues(given: Iterable[str]) -> list[Issue]:
    """A motion is said in one way, and only rows can be repeated."""
    given = list(given)
    ways = list(dict.fromkeys(MOTION_WAYS[key] for key in given if key in MOTION_WAYS))
    issues = []
    if len(ways) != 1:
        what = f"{' and '.join(ways)} are given together." if ways else "nothing says how it moves."
        issues.append(
            Issue((), what, f"Give one of {', '.join(dict.fromkeys(MOTION_WAYS.values()))}.")
        )
    elif "repeat" in given and not {"points", "file"} & {*given}:
        what = "repeat is a key of points and files only."
        issues.append(Issue(("repeat",), what, "Leave it out, or write formulas that come round."))
    return issues


def name_issues(names: Sequence[object]) -> list[Issue]:
    """Names that the user gave to obstacles are different from each other."""
    first: dict[str, int] = {}
    return [
        Issue(
            (place, "name"),
            f"obstacle {first[name]} is called {shortened(string_text(name))} too.",
            "Give every obstacle a name of its own.",
        )
        for place, name in enumerate(names)
        if isinstance(name, str) and name and first.setdefault(name, place + 1) <= place
    ]


def planner_issues(given: Iterable[str]) -> list[Issue]:
    """A key that is one slip away from a shared key is no setting of some planner."""
    return [
        unknown_key((key,), key, PLANNER_KEYS)
        for key in given
        if key not in PLANNER_KEYS and difflib.get_close_matches(key, PLANNER_KEYS, 1, cutoff=0.9)
    ]


def integration_issues(given: Mapping[str, object]) -> list[Issue]:
    """A method of integration is known, or its coefficients make it so."""
    name, tableau = given.get("method", "rk4"), given.get("tableau")
    if not isinstance(name, str):
        return []
    if isinstance(tableau, dict):
        if "method" not in given:
            what, remedy = "the tableau has no name.", 'Name it, such as method = "own".'
            return [Issue(("method",), what, remedy)]
        try:
            add_method(Method(name, **tableau | {"geodesic": False}))  # no key of files
        except InputError as error:  # types are reported elsewhere, for an argument each
            own = (each for each in error.mistakes if each.where.startswith("integration method"))
            return [Issue(("tableau",), each.what, each.remedy) for each in own]
        except TypeError:
            return []  # a key is missing or unknown, which is reported elsewhere
    if name in METHODS:
        return []
    close = difflib.get_close_matches(name, METHODS, n=1)
    meant = f'Did you mean "{close[0]}"? ' if close else ""
    listing = ", ".join(f'"{known}"' for known in METHODS)
    remedy = f"{meant}Give one of {listing}, or coefficients under [integration.tableau]."
    return [Issue(("method",), f"{shortened(string_text(name))} is none of the choices.", remedy)]


def unknown_key(path: KeyPath, key: str, known: Sequence[str], kind: str = "key") -> Issue:
    """Describe a key that nothing reads, and the nearest one that something does."""
    mistake = unknown_name(kind, shortened(key), known=sorted(known))
    return Issue(path, mistake.what, mistake.remedy)


def _exactly_one(given: Iterable[str], kinds: Sequence[str], purpose: str) -> list[Issue]:
    present = [key for key in given if key in kinds]
    if len(present) == 1:
        return []
    listing = f"{', '.join(kinds[:-1])} and {kinds[-1]}"
    if not present:
        return [Issue((), f"none of {listing} is given.", f"Give {purpose}.")]
    both = f"{', '.join(present[:-1])} and {present[-1]}"
    return [Issue((present[-1],), f"{both} are given together.", f"Keep one of {listing}.")]


def _table(value: object) -> dict[str, object]:
    return value if isinstance(value, dict) else {}
