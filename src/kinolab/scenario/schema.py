"""The scenario's schema: every key, its type, its unit and its default.

SI units and radians throughout. The models are frozen and refuse what they do not know.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    model_validator,
)
from pydantic_core import PydanticCustomError

from kinolab.dynamics.codegen.methods import METHODS, SHIPPED
from kinolab.errors import is_broken, printable
from kinolab.files import stem_of
from kinolab.scenario import rules
from kinolab.scenario.issues import Issue, KeyPath, Origin
from kinolab.scenario.values import (
    COORDINATE,
    Angle,
    AtRest,
    Axis,
    BodyName,
    BoxEdges,
    CloudPath,
    ColorNames,
    Coordinate,
    Count,
    CsvPath,
    CutHeight,
    CylinderSize,
    Direction,
    DirectionTolerance,
    Effort,
    Elevation,
    Heading,
    Limits,
    MapPath,
    Meaning,
    MeshPath,
    Metres,
    Name,
    NotNegative,
    Number,
    NumberOrAngle,
    Parts,
    PerJoint,
    PictureSize,
    PlannerName,
    PointTolerance,
    Poses,
    Position,
    Positive,
    RegionTolerance,
    RollPitchYaw,
    RunFolder,
    Scale,
    SchemaVersion,
    Seconds,
    Seed,
    Slope,
    Spin,
    StateLimits,
    Substeps,
    SystemFile,
    Text,
    ThreeFormulas,
    Tolerance,
    Velocity,
    Wanted,
    WorldAxis,
    plain_setting,
    rgb_of,
)
from kinolab.untrusted import ELEMENTS

LARGEST_CLEARANCE = 1e6  # [m]; its square must not drown the sizes of what moves
TOLERANCE = 0.1  # of every goal that does not give its own
ALL = "*"  # after the beginning of names: of a tolerance for all that is a machine's
RULE_ERROR = "kinolab_rule"  # the type of errors that several keys make together


T = TypeVar("T")
Tables = Annotated[tuple[T, ...], Field(strict=False)]  # lists in TOML; what is inside stays strict


class Section(BaseModel):
    """What all sections share: strict types, finite numbers, no unknown keys, no changes."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    free: ClassVar[Wanted | None] = None  # what free keys take, in sections that have them


class SystemSection(Section):
    """``[system]``: the machine, by its registered name or from a file."""

    name: Name | None = None
    file: SystemFile | None = None  # Python is code that runs; relative to the scenario
    base: Literal["fixed", "floating"] | None = None  # of a robot's file
    locked: dict[str, NumberOrAngle] | None = None  # positions of a robot's joints, [rad] or [m]
    self_collisions: bool | None = None  # of a robot's file
    convex_parts: Parts | None = None  # of a mesh in a robot's file, at most
    servo_commands: bool | None = None  # of an MJCF file
    kinematic: bool | None = None  # of a robot's file
    max_velocity: PerJoint | None = None  # of a kinematic robot's joints, [rad/s] or [m/s]
    max_acceleration: PerJoint | None = None  # [rad/s^2] or [m/s^2]
    density: Positive | None = None  # of links without inertia in a robot's file, [kg/m^3]
    balance_inertia: bool | None = None  # of a URDF file
    parameters: dict[str, Number] = {}
    machines: dict[str, SystemSection] | None = None  # several, side by side, by name

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = {key: getattr(self, key) for key in _given(self)}
        _obey(rules.system_issues(given, self.file))
        return self


class MotionSection(Section):
    """``motion``: where an obstacle is at a time t [s]; at 0 it may be at its position and rpy."""

    velocity: Velocity | None = None  # [m/s], along the axes of the world
    spin: Spin | None = None  # [rad/s] of roll, pitch and yaw
    position: ThreeFormulas | None = None  # x, y, z [m] as formulas in t, instead of its own
    rpy: ThreeFormulas | None = None  # roll, pitch, yaw [rad] as formulas in t
    points: Poses | None = None  # straight lines between rows of t, x, y, z[, roll, pitch, yaw]
    file: CsvPath | None = None  # such rows in a table
    repeat: bool | None = None  # whether rows begin anew where they end; it stays there otherwise

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        _obey(rules.motion_issues(_given(self)))
        return self


class ObstacleEntry(Section):
    """``[[world.obstacle]]``: one shape and where it stands."""

    mesh: MeshPath | None = None
    box: BoxEdges | None = None
    sphere: Metres | None = None  # radius
    cylinder: CylinderSize | None = None
    capsule: CylinderSize | None = None
    run: RunFolder | None = None  # the machine of another plan, which moves as was planned
    position: Position = (0.0, 0.0, 0.0)  # of the centre, or of a file's origin
    rpy: RollPitchYaw = (0.0, 0.0, 0.0)
    map: MapPath | None = None
    cloud: CloudPath | None = None
    scale: Scale = 1.0  # of a mesh or a cloud
    up: Literal["x", "y", "z"] = "z"  # the axis of the file that points up
    solid: bool | None = None  # of a mesh; left out: judged by its volume
    color: ColorNames | None = None  # in pictures; of several the mesh's pieces take one in turn
    simplify: Count | None = None  # of a mesh: triangles that are left
    resolution: Positive | None = None  # [m] edge of a map's cell, where its file says none
    height: Positive = 1.0  # [m] of a map's walls
    unknown: Literal["occupied", "free"] = "occupied"  # what a map's unknown cells are
    relief: Positive | None = None  # [m] by which white is higher than black, in a map of heights
    max_slope: Slope | None = None  # beyond which such ground is a wall
    radius: Positive | None = None  # [m] of the balls around a cloud's points
    voxel: Positive | None = None  # [m] edge of the cubes of which one point is left each
    motion: MotionSection | None = None  # how it moves; left out: it does not
    name: Name = ""  # left out: the kind and the count, or the mesh file's stem

    @property
    def colors(self) -> tuple[tuple[float, float, float], ...]:
        """The colours as red, green and blue in 0..1; none where the setting chooses."""
        given = (self.color,) if isinstance(self.color, str) else self.color or ()
        return tuple(rgb_of(text) for text in given)

    @property
    def kind(self) -> rules.ObstacleKind:
        """Which of the shapes was given."""
        return next(kind for kind in rules.OBSTACLE_KINDS if getattr(self, kind) is not None)

    @property
    def file(self) -> str | None:
        """The file that it is read from; None of what is described by numbers."""
        return self.mesh or self.map or self.cloud

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        motion = () if self.motion is None else _given(self.motion)
        given = {key: getattr(self, key) for key in _given(self)}
        _obey(rules.obstacle_issues(given, motion))
        return self


def _named(obstacles: tuple[ObstacleEntry, ...]) -> tuple[ObstacleEntry, ...]:
    """Name the nameless, around the names that are taken."""
    _obey(rules.name_issues([entry.name for entry in obstacles]))
    taken = {entry.name for entry in obstacles}
    named = []
    for count, entry in enumerate(obstacles, start=1):
        name = entry.name or _free_name(entry, count, taken)
        taken.add(name)
        named.append(entry.model_copy(update={"name": name}))
    return tuple(named)


def _free_name(entry: ObstacleEntry, count: int, taken: set[str]) -> str:
    file = entry.file
    stem = PurePosixPath(file).stem if file is not None else entry.kind
    name = stem if file is not None else f"{stem} {count}"
    while name in taken:
        name, count = f"{stem} {count}", count + 1
    return name


class WorldSection(Section):
    """``[world]``: the workspace's limits, the ground, and what stands in the way."""

    bounds: dict[WorldAxis, Annotated[Limits, Wanted("[low, high], low first [m]")]] = {}
    ground: Literal["plane", "none"] = "none"
    clearance: Annotated[
        float,
        Field(ge=0, le=LARGEST_CLEARANCE, allow_inf_nan=False),
        Wanted(f"a distance from 0 to {LARGEST_CLEARANCE:g} [m]"),
    ] = 0.0  # that plans keep from every obstacle
    obstacle: Annotated[
        Tables[ObstacleEntry],
        Field(max_length=ELEMENTS["obstacles"]),
        AfterValidator(_named),
        Wanted(f"a list of at most {ELEMENTS['obstacles']} [[world.obstacle]] tables"),
    ] = ()


class PointGoal(Section):
    """``[[goal.point]]``: a point of a body reaches a place in the world."""

    body: BodyName
    at: Position = (0.0, 0.0, 0.0)  # in the body's frame
    position: Position  # in the world
    tolerance: PointTolerance = TOLERANCE


class DirectionGoal(Section):
    """``[[goal.direction]]``: an axis of a body points where ``target`` points."""

    body: BodyName
    axis: Axis  # in the body's frame
    target: Direction  # in the world
    tolerance: DirectionTolerance = TOLERANCE


class RegionGoal(Section):
    """``[[goal.region]]``: a formula of coordinates is within limits."""

    expression: Text
    least: Number | None = None
    most: Number | None = None
    tolerance: RegionTolerance = TOLERANCE  # how far inside a limit a plan aims

    @model_validator(mode="after")
    def _limited(self) -> Self:
        _obey(rules.region_issues({key: getattr(self, key) for key in _given(self)}))
        return self


class GoalChoice(Section):
    """``[[goal.any_of]]``: values that coordinates and rates reach; what is left out is free."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Coordinate] = Field(init=False)
    free: ClassVar[Wanted | None] = Wanted(COORDINATE)

    tolerance: Tolerance = TOLERANCE  # in the units of the coordinates; [m] and [rad]
    norm: Literal["max", "sum", "euclidean"] = "max"  # of all shares of tolerances
    at_rest: AtRest = False  # or the names of those machines, of several, that shall be
    reserve: Annotated[
        float, Field(ge=0, lt=1, allow_inf_nan=False), Wanted("a share, 0 or more, below 1")
    ] = 0.0  # of every tolerance: what a plan leaves to those who carry it out
    point: Annotated[Tables[PointGoal], Wanted("a list of [[goal.point]] tables")] = ()
    direction: Annotated[Tables[DirectionGoal], Wanted("a list of [[goal.direction]] tables")] = ()
    region: Annotated[Tables[RegionGoal], Wanted("a list of [[goal.region]] tables")] = ()

    def tolerance_of(self, name: str) -> float:
        """The tolerance of a coordinate or rate, in its own unit."""
        if not isinstance(self.tolerance, dict):
            return self.tolerance
        if name in self.tolerance:
            return self.tolerance[name]
        begun = (key for key in self.tolerance if key.endswith(ALL) and name.startswith(key[:-1]))
        return self.tolerance.get(max(begun, key=len, default=""), TOLERANCE)

    def rests(self, name: str) -> bool:
        """Whether a velocity of this name is to be zero."""
        if isinstance(self.at_rest, bool):
            return self.at_rest
        return any(name.startswith(f"{machine}_") for machine in self.at_rest)

    @property
    def values(self) -> dict[str, Coordinate]:
        """The free keys: a number, or a quaternion x, y, z, w, per coordinate or rate."""
        return dict(self.__pydantic_extra__)


class GoalSection(GoalChoice):
    """``[goal]``: where the motion ends, or one of several places."""

    hold: NotNegative = 0.0  # [s] for which the machine stays there
    order: Literal["written", "any"] = "written"  # in which [[via]] and this one are reached
    any_of: Annotated[Tables[GoalChoice], Wanted("a list of [[goal.any_of]] tables")] = ()

    @model_validator(mode="after")
    def _asked_of_all(self) -> Self:
        """Let each goal of which any will do ask what is asked of all."""
        own = {"hold", "order", "any_of"}
        shared = {key: getattr(self, key) for key in self.model_fields_set - own}
        vars(self)["any_of"] = tuple(
            one.model_copy(
                update={k: v for k, v in shared.items() if k not in one.model_fields_set}
            )
            for one in self.any_of
        )
        return self


class ObjectiveSection(Section):
    """``[objective]``: what a motion costs, where that is not its duration; weights of a sum."""

    time: NotNegative = 0.0  # per [s]
    effort: NotNegative = 0.0  # of the integral of the sum of the inputs' squares
    energy: NotNegative = 0.0  # per [J] that an input does or takes up
    length: dict[BodyName, NotNegative] = {}  # per [m] of the path of a body's origin
    expression: Text | None = None  # a formula of what a second costs
    max_time: Seconds | None = None

    @model_validator(mode="after")
    def _a_cost(self) -> Self:
        _obey(rules.objective_issues({key: getattr(self, key) for key in _given(self)}))
        return self


class KeepOut(Section):
    """``[[keep_out]]``: an axis of a body stays out of a cone about a direction of the world."""

    body: BodyName
    axis: Axis
    direction: Direction
    half_angle: Angle
    clearance: Annotated[
        float, Field(ge=0, le=math.pi), Wanted("an angle from 0 to 3.14159 [rad]")
    ] = 0.0  # that plans keep from the cone


TableauRow = Annotated[list[Number], Wanted("a list of lists of numbers, such as [[], [0.5]]")]


class TableauSection(Section):
    """``[integration.tableau]``: the coefficients of a method of one's own, as ``Method`` has."""

    order: Count
    a: list[TableauRow]
    b: Annotated[list[Number], Wanted("a list of numbers, such as [0.5, 0.5]")]
    c: list[TableauRow] = []
    gamma: NotNegative = 0.0


class IntegrationSection(Section):
    """``[integration]``: what the motion is, and what counts as true."""

    method: Text = "rk4"
    tableau: TableauSection | None = None
    step: Seconds = 0.05
    substeps: Substeps = 1  # of the method, of which each step is made
    truth: Literal["continuous", "discrete"] = "continuous"

    @model_validator(mode="after")
    def _known_method(self) -> Self:
        _obey(rules.integration_issues(self.model_dump(exclude_none=True)))
        if self.method not in SHIPPED:  # a file has the coefficients, wherever they come from
            own = METHODS[self.method]
            a, c = ([list(row) for row in rows] for rows in (own.a, own.c))
            vars(self)["tableau"] = TableauSection(
                order=own.order, a=a, b=list(own.b), c=c, gamma=own.gamma
            )
        return self

    def __setstate__(self, state: dict[Any, Any]) -> None:
        """Let a process that is sent the section know the method."""
        super().__setstate__(state)
        rules.integration_issues(self.model_dump(exclude_none=True))

    @property
    def accurate_method(self) -> str:
        """The method of steps that approximate a differential equation: of order 1 is too crude."""
        return self.method if METHODS[self.method].order > 1 else "rk4"


class PlannerSection(Section):
    """``[planner]``: who searches and how long; further keys are that planner's own settings."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Annotated[Any, AfterValidator(plain_setting)]] = Field(init=False)
    free: ClassVar[Wanted | None] = Wanted(
        "a finite number, text in quotes, true or false, or a list or table of these"
    )

    name: PlannerName = "auto"  # Python is code that runs; relative to the scenario
    time_limit: Annotated[Seconds, Meaning("Longest time of a search.", "s")] = 30.0
    max_iterations: Annotated[
        Count | None,
        Meaning(
            "Most iterations of a search; any number where it is left out. Threads that share a "
            "tree end their round first.",
            "iterations",
        ),
    ] = None
    seed: Annotated[Seed, Meaning("Seed of the random numbers.")] = 1
    improve: Annotated[
        Effort,
        Meaning(
            'Work on making a motion exact and shorter, on an idle computer; 0: none. "auto": '
            "that of 60 subproblems of the whole motion, at least 2 s, and as much again while "
            "that pays, up to 30 s.",
            "s",
        ),
    ] = "auto"

    @property
    def settings(self) -> dict[str, Any]:
        """The free keys, for the planner to check; lists are tuples."""
        return dict(self.__pydantic_extra__)

    @model_validator(mode="after")
    def _no_slips(self) -> Self:
        _obey(rules.planner_issues(self.__pydantic_extra__))
        return self


UncertainShare = Annotated[
    float, Field(ge=0, lt=1, allow_inf_nan=False), Wanted("a share, 0 or more, below 1")
]


class RobustSection(Section):
    """``[robust]``: for which machines a plan is to be proved; shares of what is assumed."""

    parameters: UncertainShare | dict[Name, UncertainShare] = 0.0  # of each, or by their names
    noise: UncertainShare = 0.0  # of each state's scale, by which a measurement is off
    disturbance: UncertainShare = 0.0  # of an input's range, in every step another one


class RenderSection(Section):
    """``[render]``: how the moving picture looks."""

    view: Literal["perspective", "top", "front", "side"] = "perspective"
    azimuth: Heading | None = None  # of the camera; left out: where one sees most of the way from
    elevation: Elevation | None = None  # above the horizon; left out: by the shape of the world
    follow: bool = False  # whether the picture goes with the machine
    cut: CutHeight | None = None  # [m] above which obstacles are left out; or along the way
    setting: Literal["studio", "hall", "yard", "road", "canyon", "water", "space"] = "studio"
    speed: Positive = 1.0  # seconds of motion per second of picture
    size: PictureSize = (800, 600)
    magnify: bool = True  # whether a machine that is tiny in it is shown enlarged in a corner
    axes: bool = False  # whether frames of joints and bodies are drawn, with their names


class MachineEntry(Section):
    """``[[machine]]``: one of several machines, which become one before keys are checked."""

    name: Name
    system: SystemSection
    start: dict[str, Coordinate] = {}
    goal: GoalSection = Field(default_factory=GoalSection)
    bounds: dict[str, StateLimits] = {}
    metric: dict[str, NotNegative] = {}


class MachineTables(Section):
    """Every ``[[machine]]`` of a scenario, as they are written."""

    machine: Annotated[Tables[MachineEntry], Wanted("a list of [[machine]] tables")] = ()


class Scenario(Section):
    """Everything a scenario file says, checked and with its defaults filled in.

    Scenarios are equal when they say the same; where they were read does not count.
    """

    schema_version: SchemaVersion = Field(alias="schema")
    title: Text
    system: SystemSection
    machine: Tables[MachineEntry] = ()  # never here: see ``MachineEntry``
    world: WorldSection = Field(default_factory=WorldSection)
    bounds: dict[str, StateLimits] = {}
    metric: dict[str, NotNegative] = {}
    start: dict[str, Coordinate] = {}
    via: Annotated[Tables[GoalSection], Wanted("a list of [[via]] tables")] = ()
    goal: GoalSection = Field(default_factory=GoalSection)
    keep_out: Annotated[Tables[KeepOut], Wanted("a list of [[keep_out]] tables")] = ()
    objective: ObjectiveSection | None = None
    integration: IntegrationSection = Field(default_factory=IntegrationSection)
    planner: PlannerSection = Field(default_factory=PlannerSection)
    render: RenderSection = Field(default_factory=RenderSection)
    robust: RobustSection | None = None

    _origin: Origin = PrivateAttr(default_factory=Origin)

    @property
    def origin(self) -> Origin:
        """The file and the overrides that the scenario was read from."""
        return self._origin

    @property
    def goals(self) -> dict[KeyPath, GoalSection]:
        """What is to be reached, by where it stands: what lies on the way, and then the end."""
        on_the_way: dict[KeyPath, GoalSection] = {("via", k): g for k, g in enumerate(self.via)}
        return {**on_the_way, ("goal",): self.goal}

    @property
    def goal_tables(self) -> dict[KeyPath, GoalChoice]:
        """All tables that say where a motion goes, by where they stand."""
        goals = self.goals.items()
        any_of = {(*at, "any_of", k): o for at, g in goals for k, o in enumerate(g.any_of)}
        return {**self.goals, **any_of}

    @property
    def folder(self) -> Path:
        """Where relative paths start."""
        return self._origin.file.parent

    @property
    def name(self) -> str:
        """The stem of the file's name, as text that can be written anywhere, such as a folder."""
        stem = stem_of(self._origin.file)
        return printable(stem) if is_broken(stem) else stem

    def located(self, origin: Origin) -> Self:
        """The same scenario, read somewhere else."""
        copy = self.model_copy()
        copy._origin = origin
        return copy


def axis_vector(axis: str | tuple[float, float, float]) -> tuple[float, float, float]:
    """Turn a scenario's axis, a name such as "-z" or three numbers, into a unit vector."""
    if not isinstance(axis, str):
        largest = max(map(abs, axis))  # keeps the length from overflowing
        x, y, z = (component / largest for component in axis)
        length = math.hypot(x, y, z)
        return (x / length, y / length, z / length)
    sign = -1.0 if axis.startswith("-") else 1.0
    x, y, z = (sign if axis[-1] == letter else 0.0 for letter in "xyz")
    return (x, y, z)


def _given(section: Section) -> list[str]:
    """The keys that were set, to something."""
    given = section.model_fields_set  # has no order of its own
    fields = type(section).model_fields
    return [key for key in fields if key in given and getattr(section, key) is not None]


def _obey(issues: Sequence[Issue]) -> None:
    """Refuse what a rule refuses; the reader of files asks the rules itself, and all of them."""
    if issues:
        text = " ".join(f"{issue.what} {issue.remedy}" for issue in issues)
        raise PydanticCustomError(RULE_ERROR, "{text}", {"text": text})
