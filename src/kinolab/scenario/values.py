"""The kinds of values that a scenario's keys take, each with the phrase that asks for it.

Types are strict: a whole number may stand where a number is meant, text and booleans may not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)
from pydantic_core import PydanticCustomError

from kinolab.errors import flaw_of
from kinolab.scenario.angles import EXAMPLES, WrittenAngle, angle_of
from kinolab.scenario.user_code import python_reference

URDF_FORMATS = (".urdf", ".xacro")  # of ROS, and its templates
ROBOT_FORMATS = (*URDF_FORMATS, ".xml")  # and of MuJoCo
ROBOT_ONLY = (  # keys of [system], the files that they are for, and these in words
    ("base", URDF_FORMATS, "URDF files"),  # an MJCF file says itself whether a body is free
    ("locked", ROBOT_FORMATS, "robots from files"),
    ("self_collisions", ROBOT_FORMATS, "robots from files"),
    ("convex_parts", ROBOT_FORMATS, "robots from files"),
    ("servo_commands", (".xml",), "MJCF files"),  # a URDF file has no servos
    ("kinematic", ROBOT_FORMATS, "robots from files"),
    ("max_velocity", ROBOT_FORMATS, "robots from files"),
    ("max_acceleration", ROBOT_FORMATS, "robots from files"),
    ("density", (".urdf",), "URDF files"),  # an MJCF file has its own
    ("balance_inertia", URDF_FORMATS, "URDF files"),  # an MJCF file has balanceinertia
)
MESH_FORMATS = (".dae", ".glb", ".obj", ".off", ".ply", ".stl")
MAP_FORMATS = (".map", ".pgm", ".png", ".yaml", ".yml")
CLOUD_FORMATS = (".pcd", ".ply", ".xyz")
MOST_PARTS = 32  # of one mesh of a robot; every one is a solid that collides
WHOLE_MAX = 2**63 - 1  # what TOML promises to carry
WHOLE_POSES = 400  # rows of a path; longer ones belong into a file
SETTING_DEPTH = 8  # tables and lists within each other in a planner's own settings

USUAL_IMPROVEMENT = 2.0  # [s] of work
NUMBER_TAG, LIST_TAG, NAME_TAG, TABLE_TAG = TAGS = ("<number>", "<list>", "<name>", "<table>")


@dataclass(frozen=True)
class Wanted:
    """What a key takes, worded to follow "Give"."""

    phrase: str


@dataclass(frozen=True)
class Meaning:
    """What a key is for, in a sentence, and the unit of its values."""

    sentence: str
    unit: str = ""


def refusal(predicate: str) -> PydanticCustomError:
    """Build the error of a validator; ``predicate`` continues a sentence about the value."""
    return PydanticCustomError("kinolab_value", "{predicate}", {"predicate": predicate})


def _ascending(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] >= limits[1]:
        raise refusal("does not have its low end below its high end")
    return limits


def _nonzero(vector: tuple[float, ...]) -> tuple[float, ...]:
    if not any(vector):
        raise refusal("is zero and has no direction")
    return vector


def _exactly_int(value: object) -> object:
    """Keep ``true`` and 1.0, which Python takes for 1, from passing as a schema."""
    if type(value) is not int:
        raise refusal("is not a whole number")
    return value


def _line(text: str) -> str:
    if flaw := flaw_of(text):
        raise refusal(flaw)
    return text


def _title(text: str) -> str:
    if flaw := flaw_of(text.replace("\n", " "), len(text)):
        raise refusal(flaw)
    return text


def _world_file(noun: str, formats: Sequence[str]) -> Callable[[str], str]:
    def checked(text: str) -> str:
        if not _is_relative(text) or ".." in PurePosixPath(text).parts:
            raise refusal("does not lead to a file below the scenario's folder")
        if PurePosixPath(text).suffix.lower() not in formats:
            raise refusal(f"is not a {noun} format that kinolab reads")
        _line(PurePosixPath(text).name)  # it names the obstacle
        return text

    return checked


def _csv_path(text: str) -> str:
    if not _is_relative(text) or ".." in PurePosixPath(text).parts:
        raise refusal("does not lead to a file below the scenario's folder")
    return text


def _pose_row(row: tuple[float, ...]) -> tuple[float, ...]:
    if len(row) not in (4, 7):
        raise refusal("has neither four nor seven numbers")
    return row


def _system_file(text: str) -> str:
    python = python_reference(text)
    if python is None and not text.endswith((".json", ".py", *ROBOT_FORMATS)):
        raise refusal("does not name a machine in a file")
    path = python[0] if python else text
    if not (_is_relative(path) or _is_absolute(path)):
        raise refusal("is no path, neither absolute nor relative to the scenario's folder")
    return text


def _planner_name(text: str) -> str:
    """Let every text pass as a name, but for a file that cannot be read as file.py:Class."""
    python = python_reference(text)
    if python is None and text.rpartition(":")[0].endswith(".py") | text.endswith(".py"):
        raise refusal("does not name a class in a file")
    if python is not None and not _is_relative(python[0]):
        raise refusal("is not relative to the scenario's folder")
    return text


def _is_relative(text: str) -> bool:
    """Whether a path is relative on every system, so that a scenario can be mailed."""
    windows = PureWindowsPath(text)
    return not (windows.drive or windows.root or "\\" in text or "\0" in text)


def _is_absolute(text: str) -> bool:
    """Whether a path is absolute here: a machine may be where a package of robots has it."""
    return Path(text).is_absolute() and "\0" not in text


def plain_setting(value: object, depth: int = 0) -> Any:
    """Check one of a planner's own settings: a finite TOML value, lists as tuples."""
    if depth > SETTING_DEPTH:
        raise refusal(f"is nested more than {SETTING_DEPTH} deep")
    if isinstance(value, list | tuple):
        return tuple(plain_setting(item, depth + 1) for item in value)
    if isinstance(value, dict):
        return {key: plain_setting(item, depth + 1) for key, item in value.items()}
    if isinstance(value, float) and not math.isfinite(value):
        raise refusal("is not finite" if depth == 0 else "holds a number that is not finite")
    if isinstance(value, int) and not -WHOLE_MAX <= value <= WHOLE_MAX:
        raise refusal("is too large" if depth == 0 else "holds a number that is too large")
    if not isinstance(value, bool | int | float | str):
        raise refusal("is not something a planner can use")
    return value


def rgb_of(text: str) -> tuple[float, float, float]:
    """Red, green and blue in 0..1 of a colour such as "#c8553d"."""
    red, green, blue = (int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def _number_or_angle(value: object, number: ValidatorFunctionWrapHandler) -> object:
    """Read an angle that is text; whether what it is given to is one, its machine tells later."""
    if not isinstance(value, str):
        return value if isinstance(value, WrittenAngle) else number(value)
    angle = angle_of(value)
    if angle is None:
        raise refusal("is text, not a number")
    return angle


def _either(default: str, kinds: Any, tag: str) -> Discriminator:
    """Choose a union's branch first, so that a mistake is told about that branch alone."""
    return Discriminator(lambda value: tag if isinstance(value, kinds) else default)


def improvement_seconds(effort: float | Literal["auto"]) -> float:
    """Return the work on making a motion of usual length exact and shorter, in [s]."""
    return USUAL_IMPROVEMENT if effort == "auto" else effort


_NUMBER_OR_NAME = _either(NUMBER_TAG, str, NAME_TAG)
_NUMBER_OR_LIST = _either(NUMBER_TAG, (list, tuple), LIST_TAG)
_NAME_OR_LIST = _either(NAME_TAG, (list, tuple), LIST_TAG)
_List = Field(strict=False)  # TOML has lists where Python has tuples; the entries stay strict

SchemaVersion = Annotated[
    Literal[1],
    BeforeValidator(_exactly_int),
    Wanted("schema = 1; a newer schema needs a newer kinolab"),
]
Text = Annotated[
    str, Field(min_length=1), AfterValidator(_title), Wanted("a line of text in quotes")
]
Name = Annotated[str, Field(min_length=1), AfterValidator(_line), Wanted("a name in quotes")]
BodyName = Annotated[Name, Wanted("the name of a body in quotes")]
PlannerName = Annotated[
    str,
    Field(min_length=1),
    AfterValidator(_planner_name),
    Wanted('the name of a planner in quotes, or "my_planner.py:Class"'),
]
SystemFile = Annotated[
    str,
    AfterValidator(_system_file),
    Wanted('"my_machine.py:crane", "machine.json" or "robot.urdf"'),
]
MeshPath = Annotated[
    str,
    AfterValidator(_world_file("mesh", MESH_FORMATS)),
    Wanted(f'a relative path such as "meshes/maze.stl" ({", ".join(MESH_FORMATS)})'),
]
MapPath = Annotated[
    str,
    AfterValidator(_world_file("map", MAP_FORMATS)),
    Wanted(f'a relative path such as "maps/office.yaml" ({", ".join(MAP_FORMATS)})'),
]
CloudPath = Annotated[
    str,
    AfterValidator(_world_file("cloud", CLOUD_FORMATS)),
    Wanted(f'a relative path such as "scans/hall.ply" ({", ".join(CLOUD_FORMATS)})'),
]

ColorName = Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$"), Wanted('a colour such as "#c8553d"')]
Number = Annotated[float, Wanted("a number")]
NumberOrAngle = Annotated[
    float, WrapValidator(_number_or_angle), Wanted(f"a number, or an angle such as {EXAMPLES}")
]
Positive = Annotated[float, Field(gt=0), Wanted("a positive number")]
NotNegative = Annotated[float, Field(ge=0), Wanted("a number that is not negative")]
Seconds = Annotated[float, Field(gt=0), Wanted("a positive number [s]")]
Effort = Annotated[
    Annotated[float, Field(ge=0), Tag(NUMBER_TAG)] | Annotated[Literal["auto"], Tag(NAME_TAG)],
    _NUMBER_OR_NAME,
    Wanted('a number that is not negative [s], or "auto"'),
]
Metres = Annotated[float, Field(gt=0), Wanted("a positive number [m]")]
Angle = Annotated[
    NumberOrAngle, Field(gt=0, le=math.pi), Wanted("a positive number of at most 3.14159 [rad]")
]
Slope = Annotated[
    NumberOrAngle,
    Field(gt=0, lt=math.pi / 2),
    Wanted("an angle above 0 and below 1.5708 [rad]"),
]
Heading = Annotated[
    NumberOrAngle,
    Field(ge=-2 * math.pi, le=2 * math.pi),
    Wanted("an angle from -6.28319 to 6.28319 [rad]"),
]
Elevation = Annotated[
    NumberOrAngle,
    Field(ge=-math.pi / 2, le=math.pi / 2),
    Wanted("an angle from -1.5708 to 1.5708 [rad]"),
]
Count = Annotated[int, Field(ge=1, le=WHOLE_MAX), Wanted("a whole number from 1 to 2^63 - 1")]
Parts = Annotated[int, Field(ge=1, le=MOST_PARTS), Wanted("a whole number from 1 to 32")]
Substeps = Annotated[int, Field(ge=1, le=1000), Wanted("a whole number from 1 to 1000")]
Seed = Annotated[
    int,
    Field(ge=0, le=WHOLE_MAX),
    Wanted("a whole number from 0 to 2^63 - 1"),
]
AtRest = Annotated[
    Annotated[bool, Tag(NUMBER_TAG)] | Annotated[tuple[Name, ...], _List, Tag(LIST_TAG)],
    _NUMBER_OR_LIST,
    Wanted("true, false or a list of machines"),
]
Pixels = Annotated[int, Field(ge=64, le=4096)]

Limits = Annotated[
    tuple[float, float],
    _List,
    AfterValidator(_ascending),
    Wanted("[low, high] with low below high"),
]
StateLimits = Annotated[
    tuple[NumberOrAngle, NumberOrAngle],
    _List,
    AfterValidator(_ascending),
    Wanted(f"[low, high] with low below high; angles may be text such as {EXAMPLES}"),
]
Position = Annotated[
    tuple[float, float, float], _List, Wanted("a list of three numbers x, y, z [m]")
]
RollPitchYaw = Annotated[
    tuple[NumberOrAngle, NumberOrAngle, NumberOrAngle],
    _List,
    Wanted("a list of three numbers roll, pitch, yaw [rad]"),
]
Velocity = Annotated[
    tuple[float, float, float], _List, Wanted("a list of three numbers along x, y, z [m/s]")
]
Spin = Annotated[
    tuple[NumberOrAngle, NumberOrAngle, NumberOrAngle],
    _List,
    Wanted("a list of three numbers, of roll, pitch and yaw [rad/s]"),
]
ThreeFormulas = Annotated[
    tuple[Text, Text, Text],
    _List,
    Wanted('a list of three formulas in t [s], such as ["2 * sin(t)", "0", "0.5"]'),
]
Pose = Annotated[
    tuple[float, ...],
    _List,
    AfterValidator(_pose_row),
    Wanted("a row [t, x, y, z] or [t, x, y, z, roll, pitch, yaw]"),
]
Poses = Annotated[
    tuple[Pose, ...],
    _List,
    Field(min_length=2, max_length=WHOLE_POSES),
    Wanted("a list of rows [t, x, y, z] or [t, x, y, z, roll, pitch, yaw], the times rising"),
]
RunFolder = Annotated[Name, Wanted('the folder of a run, such as "runs/truck"')]
CsvPath = Annotated[str, AfterValidator(_csv_path), Wanted('a relative path such as "cart.csv"')]
Direction = Annotated[
    tuple[float, float, float],
    _List,
    AfterValidator(_nonzero),
    Wanted("a list of three numbers that are not all zero"),
]
Quaternion = Annotated[
    tuple[float, float, float, float],
    _List,
    AfterValidator(_nonzero),
    Wanted("a list of four numbers x, y, z, w that are not all zero"),
]
BoxEdges = Annotated[
    tuple[Metres, Metres, Metres], _List, Wanted("a list of three positive numbers, full edges [m]")
]
CylinderSize = Annotated[
    tuple[Metres, Metres], _List, Wanted("a list of two positive numbers, radius and length [m]")
]
PictureSize = Annotated[
    tuple[Pixels, Pixels],
    _List,
    Wanted("a list of two whole numbers from 64 to 4096, width and height [pixels]"),
]

COORDINATE = f"a number, an angle such as {EXAMPLES}, or four numbers x, y, z, w for a rotation"
Coordinate = Annotated[
    Annotated[NumberOrAngle, Tag(NUMBER_TAG)] | Annotated[Quaternion, Tag(LIST_TAG)],
    _NUMBER_OR_LIST,
    Wanted(COORDINATE),
]
LEAST_TOLERANCE = 1e-12  # of a goal: what is smaller is rounding
Tolerance = Annotated[
    Annotated[float, Field(ge=LEAST_TOLERANCE), Tag(NUMBER_TAG)]
    | Annotated[dict[str, Annotated[NumberOrAngle, Field(ge=LEAST_TOLERANCE)]], Tag(TABLE_TAG)],
    _either(NUMBER_TAG, dict, TABLE_TAG),
    Wanted(
        f"a number of at least {LEAST_TOLERANCE:g}, or a table with one such number for each name"
    ),
]
PerJoint = Annotated[
    Annotated[Positive, Tag(NUMBER_TAG)] | Annotated[dict[str, Positive], Tag(TABLE_TAG)],
    _either(NUMBER_TAG, dict, TABLE_TAG),
    Wanted("a positive number, or a table with one for each joint"),
]
RegionTolerance = Annotated[
    float, Field(ge=LEAST_TOLERANCE), Wanted(f"a number of at least {LEAST_TOLERANCE:g}")
]
PointTolerance = Annotated[
    float, Field(ge=LEAST_TOLERANCE), Wanted(f"a number of at least {LEAST_TOLERANCE:g} [m]")
]
DirectionTolerance = Annotated[
    NumberOrAngle,
    Field(ge=LEAST_TOLERANCE, le=math.pi),
    Wanted(f"a number from {LEAST_TOLERANCE:g} to 3.14159 [rad]"),
]
Scale = Annotated[
    Annotated[Positive, Tag(NUMBER_TAG)]
    | Annotated[tuple[Positive, Positive, Positive], _List, Tag(LIST_TAG)],
    _NUMBER_OR_LIST,
    Wanted("a positive number, or a list of three of them"),
]
ColorNames = Annotated[
    Annotated[ColorName, Tag(NAME_TAG)]
    | Annotated[tuple[ColorName, ...], _List, Field(min_length=1), Tag(LIST_TAG)],
    _NAME_OR_LIST,
    Wanted('a colour such as "#c8553d", or a list of them'),
]
CutHeight = Annotated[
    Annotated[float, Tag(NUMBER_TAG)] | Annotated[Literal["way"], Tag(NAME_TAG)],
    _NUMBER_OR_NAME,
    Wanted('a height [m], or "way"'),
]
WORLD_AXES = ("x", "y", "z")
WorldAxis = Annotated[str, Field(pattern="^[xyz]$")]
AxisName = Literal["x", "y", "z", "-x", "-y", "-z"]
Axis = Annotated[
    Annotated[AxisName, Tag(NAME_TAG)] | Annotated[Direction, Tag(LIST_TAG)],
    _NAME_OR_LIST,
    Wanted('"x", "y", "z", "-x", "-y", "-z", or a list of three numbers that are not all zero'),
]
