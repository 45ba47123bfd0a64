"""What a problem file of OMPL.app says, checked as far as it goes without its meshes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from kinolab.scenario.file_lookup import read_text
from kinolab.scenario.omplapp.cfg_text import CfgFile, CfgValue, cfg_file
from kinolab.scenario.omplapp.wanted_planner import WantedPlanner, wanted_planner

AXES, ENDS = "xyz", ("start", "goal")
PLANAR_CONTROLS = ("kinematic_car", "dynamic_car")
SPATIAL_CONTROLS = ("blimp", "quadrotor")
STATE_SPACES = ("dubins", "reedsshepp")  # of a car in the plane; left out: SE(2)
PLACE = tuple(f"{end}.{axis}" for end in ENDS for axis in AXES)
TURN = tuple(f"{end}.{key}" for end in ENDS for key in ("theta", "axis.x", "axis.y", "axis.z"))
VOLUME = tuple(f"volume.{end}.{axis}" for end in ("min", "max") for axis in AXES)
SPATIAL = tuple(key for key in (*PLACE, *TURN) if key.endswith((".z", ".axis.x", ".axis.y")))
NUMBERS = (*PLACE, *TURN, *VOLUME, "threshold", "turningradius")
TEXTS = ("name", "robot", "world", "control", "statespace")
# What kinolab has another way of doing, or none: it is accepted, and told.
UNUSED = ("objective", "objective.threshold", "solution_length", "sampler")
UNUSED_BEGINNINGS = ("longest_valid_segment_fraction", "valid_segment_count_factor", "projection.")
OF_RUNS = ("mem_limit", "run_count", "output", "save_paths", "simplify")  # of a benchmark
LEAST_AXIS = 1e-9  # length of an axis that says which way it points


@dataclass(frozen=True)
class CfgPose:
    """Where a robot is.

    Attributes:
        place: x and y, in space z, in [m].
        angle: By which it is turned, in [rad].
        axis: About which, a unit vector; z in the plane.
    """

    place: tuple[float, ...]
    angle: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """The rotation as x, y, z, w."""
        x, y, z = (math.sin(self.angle / 2) * component for component in self.axis)
        return x, y, z, math.cos(self.angle / 2)


@dataclass(frozen=True)
class ProblemFile:
    """A file in which no mistakes were found.

    Attributes:
        name: Of the problem.
        robot: The mesh that moves.
        world: The mesh that stands.
        control: How it moves; empty for a body that moves freely.
        space: ``dubins``, ``reedsshepp``, or empty.
        start: Where it is.
        goal: Where it shall be.
        volume: Lower and upper limits of x, y and z; empty if the world decides.
        threshold: Distance from the goal that will do; none if the file does not say.
        radius: Of the tightest turn of a ``space``, in [m].
        time_limit: Of a search, in [s]; none if the file does not say.
        planner: What it says of planners.
        notes: Sentences on what the file says and kinolab does not do.
    """

    name: str
    robot: CfgValue
    world: CfgValue
    control: str
    space: str
    start: CfgPose
    goal: CfgPose
    volume: tuple[tuple[float, ...], ...]
    threshold: float | None
    radius: float
    time_limit: float | None
    planner: WantedPlanner
    notes: tuple[str, ...]

    @property
    def axes(self) -> str:
        """The directions in which it moves: ``xy`` or ``xyz``."""
        return AXES[: len(self.start.place)]


def read_problem(path: Path) -> tuple[ProblemFile | None, CfgFile]:
    """Read a problem file and list its mistakes instead of raising them.

    Returns:
        What it says, or None where it has mistakes; and its lines with the mistakes.

    Raises:
        InputError: If there is no such file, or it is too long.
    """
    file = cfg_file(read_text(path), path.name, ("problem", "benchmark", "planner"))
    file.check_keys("problem", (*NUMBERS, *TEXTS, *UNUSED), UNUSED_BEGINNINGS)
    file.check_keys("benchmark", ("time_limit", *OF_RUNS), ())
    problem = _problem(file, Path(path).stem)
    return (None if file.found else problem), file


def _problem(file: CfgFile, stem: str) -> ProblemFile | None:
    """Return what a file says; it is whole where no mistake was found."""
    table, runs = file.table("problem"), file.table("benchmark")
    if not table:
        file.missing(
            "the section [problem] is missing, or empty.", "Give robot, world, start and goal."
        )
        return None
    spatial = any(key in table for key in SPATIAL)
    numbers = {key: file.number(table.get(key)) for key in (*PLACE, *TURN, *VOLUME)}
    _require(file, table, spatial=spatial)
    control = _control(file, table, spatial=spatial)
    space = file.chosen(table.get("statespace"), "state space", dict.fromkeys(STATE_SPACES)) or ""
    if space and (control or spatial):
        what = "it is for a body in the plane without control."
        file.wrong(table["statespace"], what, "Leave it out.")
    radius = file.number(table.get("turningradius"), positive=True)
    start, goal = (_pose(file, table, numbers, end, spatial=spatial) for end in ENDS)
    volume = _volume(file, table, numbers, spatial=spatial)
    for key in ("mem_limit", "run_count"):
        file.number(runs.get(key), positive=True)
    time_limit = file.number(runs.get("time_limit"), positive=True)
    threshold = file.number(table.get("threshold"), positive=True)
    planner = wanted_planner(file)
    if start is None or goal is None or not {"robot", "world"} <= table.keys():
        return None
    name = table["name"].text if "name" in table else ""
    return ProblemFile(
        name=name or stem,
        robot=table["robot"],
        world=table["world"],
        control=control,
        space=space,
        start=start,
        goal=goal,
        volume=volume,
        threshold=threshold,
        radius=radius or 1.0,
        time_limit=time_limit,
        planner=planner,
        notes=_notes(table),
    )


def _require(file: CfgFile, table: dict[str, CfgValue], *, spatial: bool) -> None:
    """Name what is missing, with what else makes a whole of it."""
    for key in ("robot", "world"):
        if key not in table or not table[key].text:
            file.missing(f"[problem] {key} is missing.", "Give the file of a mesh.")
    for end in ENDS:
        wanted = [f"{end}.{axis}" for axis in (AXES if spatial else AXES[:2])] + [f"{end}.theta"]
        wanted += [f"{end}.axis.{axis}" for axis in AXES] if spatial else []
        absent = [key for key in wanted if key not in table]
        if absent:
            where = "space" if spatial else "the plane"
            what = f"[problem] {_listed(absent)} missing."
            file.missing(what, f"In {where}, give {', '.join(wanted)}.")


def _listed(keys: list[str]) -> str:
    return f"{', '.join(keys)} {'is' if len(keys) == 1 else 'are'}"


def _control(file: CfgFile, table: dict[str, CfgValue], *, spatial: bool) -> str:
    known = (*PLANAR_CONTROLS, *SPATIAL_CONTROLS)
    control = file.chosen(table.get("control"), "control", dict.fromkeys(known))
    fitting = SPATIAL_CONTROLS if spatial else PLANAR_CONTROLS
    if control is not None and control not in fitting:
        moves = "in the plane, and start or goal is in space" if spatial else "in space"
        remedy = f"Here, {' and '.join(fitting)} work."
        file.wrong(table["control"], f"{control} moves {moves}.", remedy)
    return control or ""


def _pose(
    file: CfgFile,
    table: dict[str, CfgValue],
    numbers: dict[str, float | None],
    end: str,
    *,
    spatial: bool,
) -> CfgPose | None:
    """Return start or goal, None where numbers are missing."""
    place = [numbers[f"{end}.{axis}"] for axis in (AXES if spatial else AXES[:2])]
    angle = numbers[f"{end}.theta"]
    axis = [numbers[f"{end}.axis.{name}"] for name in AXES] if spatial else [0.0, 0.0, 1.0]
    if angle is None or None in place or None in axis:
        return None
    x, y, z = (float(component or 0.0) for component in axis)
    length = math.hypot(x, y, z)
    if length < LEAST_AXIS and angle:
        wrong = table[f"{end}.axis.x"]
        file.wrong(wrong, "the axis is 0, 0, 0.", "1, 0, 0 points along x.")
        return None
    unit = (x / length, y / length, z / length) if length >= LEAST_AXIS else (0.0, 0.0, 1.0)
    return CfgPose(tuple(float(entry or 0.0) for entry in place), angle, unit)


def _volume(
    file: CfgFile, table: dict[str, CfgValue], numbers: dict[str, float | None], *, spatial: bool
) -> tuple[tuple[float, ...], ...]:
    """Return lower and upper limits, empty where none are given."""
    axes = AXES if spatial else AXES[:2]
    wanted = [f"volume.{end}.{axis}" for end in ("min", "max") for axis in axes]
    given = [key for key in VOLUME if key in table]
    absent = [key for key in wanted if key not in table]
    if not given:
        return ()
    if absent:
        what = f"{_listed(absent)} missing."
        file.wrong(table[given[0]], what, "Give all limits, or none: then the world decides.")
        return ()
    low, high = ([numbers[f"volume.{end}.{axis}"] for axis in axes] for end in ("min", "max"))
    for axis, least, most in zip(axes, low, high, strict=True):
        if least is not None and most is not None and not least < most:
            what = f"volume.min.{axis} is {least:g} and volume.max.{axis} {most:g}."
            file.wrong(table[f"volume.max.{axis}"], what, "Put min below max.")
    return tuple(tuple(float(entry or 0.0) for entry in row) for row in (low, high))


def _notes(table: dict[str, CfgValue]) -> tuple[str, ...]:
    notes = []
    objective = table.get("objective")
    if objective is not None and not objective.text.startswith("length"):
        notes.append(f"kinolab makes motions short in time; objective {objective.text} is not its.")
    unused = [key for key in table if key in UNUSED[2:] or key.startswith(UNUSED_BEGINNINGS)]
    if unused:
        notes.append(f"{', '.join(unused)}: kinolab has no such setting.")
    return tuple(notes)
