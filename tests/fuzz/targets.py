"""Readers of kinolab as functions of bytes: what is not a documented error comes out of them.

Each target takes the content of one file, or of one command line, and gives it to its reader. An
``InputError`` is an answer; anything else that a reader raises is a bug, and so is an answer that
takes more than ``MOST_SECONDS`` or more memory than ``kinolab.untrusted.MEMORY``.
"""

from __future__ import annotations

import atexit
import hashlib
import io
import json
import os
import pickle
import shutil
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, cast

import kinolab
from kinolab.errors import InputError, KinolabError
from kinolab.files import utf_8
from kinolab.problem import PlanningTask
from tests.fuzz import mutation
from tests.support import OPEN, WALL

MOST_SECONDS = 5.0  # [s] of processor time for one input
SEARCH_SECONDS = 0.5  # [s] for a search, after which it is verified for five seconds at most
PLAN_SECONDS = SEARCH_SECONDS + MOST_SECONDS + 2.5
CORPUS = Path(__file__).with_name("corpus")
POST = (CORPUS / "mesh_off" / "post").read_text() if (CORPUS / "mesh_off" / "post").exists() else ""
QUICK = {"rolling_disk", "diff_drive"}  # machines that are built from what was read


@dataclass(frozen=True)
class Target:
    """One reader.

    Attributes:
        name: Of its folder in the corpus.
        run: Gives bytes to it; raises what is no documented error.
        mutate: Damages an input that it knows how to read.
        packages: Of kinolab, that it leads through.
        seconds: Of processor time, that one input may take.
    """

    name: str
    run: Callable[[bytes], None]
    mutate: mutation.Mutator
    packages: tuple[str, ...]
    seconds: float = MOST_SECONDS

    def seeds(self) -> dict[str, bytes]:
        """Return its inputs in the corpus, by name."""
        return {path.name: path.read_bytes() for path in sorted((CORPUS / self.name).iterdir())}


TARGETS: dict[str, Target] = {}


def _target(
    mutate: mutation.Mutator, *packages: str, seconds: float = MOST_SECONDS
) -> Callable[[Callable[[bytes], None]], Callable[[bytes], None]]:
    def enter(run: Callable[[bytes], None]) -> Callable[[bytes], None]:
        name = run.__name__.removeprefix("read_")
        TARGETS[name] = Target(name, run, mutate, packages, seconds)
        return run

    return enter


# --- the places where inputs are put ---


@cache
def home() -> Path:
    """Return a folder of this process's own, removed at its end."""
    folder = tempfile.mkdtemp(prefix="kinolab_fuzz")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _put(name: str, data: bytes) -> Path:
    path = home() / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


@contextmanager
def _own_cache() -> Iterator[Path]:
    """Keep what readers put into the cache out of the user's, and not for long."""
    place = home() / "cache"
    before = os.environ.get("KINOLAB_CACHE")
    place.mkdir(exist_ok=True)
    os.environ["KINOLAB_CACHE"] = str(place)
    try:
        yield place
    finally:
        if before is None:
            del os.environ["KINOLAB_CACHE"]
        else:
            os.environ["KINOLAB_CACHE"] = before
        shutil.rmtree(place, ignore_errors=True)


@cache
def coin() -> PlanningTask:
    """A coin on a table, whose files are read."""
    return kinolab.load(_put("coin/table.toml", (OPEN + WALL).encode()))


# --- scenarios ---

KEYS = (
    *("schema", "title", "system", "world", "start", "goal", "planner", "bounds", "integration"),
    *("name", "file", "parameters", "obstacle", "box", "sphere", "cylinder", "mesh", "position"),
    *("map", "cloud", "resolution", "relief", "max_slope", "radius", "voxel", "unknown"),
    *("rpy", "scale", "up", "solid", "simplify", "ground", "clearance", "tolerance", "at_rest"),
    *("point", "pointing", "keep_out", "body", "axis", "direction", "half_angle", "metric"),
    *("render", "view", "speed", "size", "step", "substeps", "method", "truth", "time_limit"),
    *("improve", "max_iterations", "goal_bias", "norm", "reserve", "coin", "x", "y", "psi", "phi"),
    *("psi_dot", "drive", "steer", "rolling_disk", "crane", "rrt", "prm", "auto", "plane", "none"),
    *("meshes/post.off", "machine.json", "machine.py:f", "planner.py:P", "pi/2", "90 deg/s"),
)


@_target(mutation.of_toml(*KEYS), "scenario", "loading", "problem")
def read_scenario(data: bytes) -> None:
    """A scenario, and the problem that it describes where its machine is quickly there."""
    from kinolab.loading.build import built
    from kinolab.scenario import read_scenario, write_scenario

    _put("scenario/meshes/post.off", POST.encode())
    path = _put("scenario/scenario.toml", data)
    with suppress(InputError):
        scenario, mistakes = read_scenario(path)
        _told(mistakes)
        if scenario is not None and not mistakes:
            write_scenario(scenario)
        system = None if scenario is None else scenario.system
        if scenario is None or system is None or system.name not in QUICK or system.parameters:
            return
        if not {"drive", "steer", "left", "right"} & set(scenario.bounds):  # else it is compiled
            built(scenario, mistakes)


@_target(mutation.of_numbers, "scenario", "loading", "problem", "solve", seconds=PLAN_SECONDS)
def read_planning(data: bytes) -> None:
    """A scenario that is planned for: the search ends with its time limit, and so does the rest."""
    path = _put("planning/scenario.toml", data)
    with suppress(KinolabError):
        problem = kinolab.load(path)
        problem.solve(seed=1, time_limit=SEARCH_SECONDS, optimize=False)


@_target(mutation.of_bytes(*(key.encode() for key in KEYS), b".", b"=", b"\n"), "scenario")
def read_overrides(data: bytes) -> None:
    """``--set KEY=VALUE``, one each line."""
    from kinolab.scenario.load import check_document

    texts = data.decode(errors="surrogateescape").split("\n")
    document = tomllib.loads(OPEN + WALL)
    _, mistakes = check_document(document, home() / "table.toml", overrides=texts)
    _told(mistakes)


@_target(
    mutation.of_bytes(
        *(b"--part", b"1/2", b"--size", b"640x480", b"--view", b"follow", b"--fps", b"--jobs"),
        *(b"--seed", b"--json", b"--help", b"--", b"-", b"=", b"bench", b"video", b"plot", b"new"),
        *(b"--set", b"scenario", b"execute", b"--times", b"--parameters", b"\n"),
    ),
    "cli",
)
def read_arguments(data: bytes) -> None:
    """A command and its arguments, one each line, as far as they are read before it runs."""
    import click

    from kinolab.cli.commands.plan_bench import _part
    from kinolab.cli.front import COMMANDS, plan

    texts = data.replace(b"\0", b"").decode(errors="surrogateescape").split("\n")
    name, *rest = texts if texts[0] in COMMANDS else ["scenario", *texts]
    with suppress(InputError, click.ClickException, click.exceptions.Exit), _quiet():
        command = plan.get_command(click.Context(plan), name)
        assert command is not None
        context = command.make_context(name, rest)
        _part(context.params.get("part"))


@contextmanager
def _quiet() -> Iterator[None]:
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        yield


def _told(mistakes: Any) -> None:
    for mistake in mistakes:
        str(mistake)


@_target(
    mutation.of_bytes(
        b"environment:", b"robots:", b"obstacles:", b"- type: box", b"center:", b"size:", b"start:",
        b"goal:", b"*a", b"&a ", b"!!python/object:os.system", b"---\n", b"unicycle1_v0",
        b"quad3d_v0",
        b"[.inf]", b".nan", b"min:", b"max:", b"? ", b"|\n", b"~",
    ),
    "scenario", "loading",
)  # fmt: skip
def read_dynobench(data: bytes) -> None:
    """An environment of dynobench."""
    from kinolab.loading.build import built
    from kinolab.scenario.dynobench import read_environment

    with suppress(InputError):
        scenario, mistakes = read_environment(_put("dynobench/env.yaml", data))
        _told(mistakes)
        if scenario is not None and scenario.system.name == "unicycle1_v0":
            built(scenario, mistakes)


@_target(
    mutation.of_bytes(
        b"[problem]", b"[planner]", b"[benchmark]", b"robot = bar.obj", b"world = bar.stl", b"../",
        b"control = ", b"kinematic_car", b"dynamic_car", b"blimp", b"quadrotor", b"start.",
        b"goal.", b"axis.x", b"theta", b"volume.min.x", b"statespace = dubins", b"nan",
        b"turningradius", b"1e999", b"threshold", b"rrt.goal_bias", b"problem.", b"#", b"=", b"\n",
    ),
    "scenario", "robots", "loading",
)  # fmt: skip
def read_omplapp(data: bytes) -> None:
    """A problem file of OMPL.app, beside a mesh that is read."""
    from kinolab.loading.omplapp_problem import read_problem_file

    _put("omplapp/bar.obj", (CORPUS / "mesh_obj" / "quads").read_bytes())
    with suppress(InputError):
        scenario, mistakes = read_problem_file(_put("omplapp/problem.cfg", data))
        _told(mistakes)
        assert scenario is None or scenario.origin.machine is not None


@_target(
    mutation.of_bytes(b"<node>", b"</node>", b"<p>", b"NORMAL", b"-1 ", b"9e9", b"Z_UP"), "robots"
)
def read_robot_mesh(data: bytes) -> None:
    """A mesh of a robot of OMPL.app: where its centre is, and the solids around it."""
    from kinolab.loading.omplapp_problem import read_problem_file

    _put("robot_mesh/robot.dae", data)
    _put("robot_mesh/world.obj", (CORPUS / "mesh_obj" / "quads").read_bytes())
    text = (
        (CORPUS / "omplapp" / "planar").read_text().replace("robot = bar.obj", "robot = robot.dae")
    )
    text = text.replace("world = bar.obj", "world = world.obj")
    with suppress(InputError):
        _, mistakes = read_problem_file(_put("robot_mesh/problem.cfg", text.encode()))
        _told(mistakes)


# --- machines ---

WORDS = (
    *(
        "is",
        "expression",
        "body",
        "attitude",
        "add",
        "mul",
        "pow",
        "sin",
        "cos",
        "tan",
        "exp",
        "log",
    ),
    *("tanh", "atan", "abs", "sign", "max", "ratio", "pi", "E", "Translation", "Rotation", "Frame"),
    *(
        "Axis",
        "Gravity",
        "Spring",
        "Viscous",
        "Coulomb",
        "Torque",
        "Force",
        "Pull",
        "Rate",
        "Drive",
    ),
    *("Control", "Regulator", "Feedback", "Reference", "QuasiVelocity", "Box", "Sphere", "Disk"),
    *("Mode", "Transition", "Cable", "State", "theta", "x", "m", "g", "bob", "default", "unit"),
    *("references", "inputs", "laws", "reference", "name", "limits", "speed", "scale", "kind"),
)


@_target(mutation.of_json(*WORDS), "dynamics.language", "dynamics.symbols")
def read_machine(data: bytes) -> None:
    """machine.json; what was read is written again."""
    from kinolab.dynamics.language.json.machine_file import load_machine, machine_to_json

    with suppress(InputError):
        machine_to_json(load_machine(_put("machine/machine.json", data)))


@_target(mutation.of_json(*WORDS), "dynamics.language", "dynamics.symbols")
def read_feedback(data: bytes) -> None:
    """feedback.json beside the machine that it is for."""
    from kinolab.dynamics.language.json.machine_file import files_of, load_machine

    plant = "falling_disk" if b"Regulator" in data else "unicycle"
    path = _put("feedback/machine.json", (CORPUS / "machine" / plant).read_bytes())
    _put("feedback/feedback.json", data)
    with suppress(InputError):
        files_of(load_machine(path))


@_target(
    mutation.of_bytes(
        *(b"<link", b"<joint", b"<inertial>", b"</robot>", b"<mimic", b"<limit", b"<axis", b"/>"),
        *(b"revolute", b"prismatic", b"continuous", b"floating", b"planar", b"fixed", b"nan"),
        *(b'"', b"1e999", b"-", b"0 0 0", b"<mesh", b"package://", b"<!--", b"<![CDATA[", b"&#0;"),
        *(b"scale=", b"rpy=", b"xyz=", b"name=", b"parent", b"child", b"lower=", b"upper="),
    ),
    "robots",
)
def read_urdf(data: bytes) -> None:
    """A robot's URDF file."""
    from kinolab.robots import read_urdf as read

    with suppress(InputError):
        read(_put("urdf/robot.urdf", data))


# --- runs ---

NAMES = ("x", "y", "psi", "phi", "psi_dot", "phi_dot"), ("drive", "steer")


@_target(mutation.of_csv, "trajectory")
def read_trajectory_csv(data: bytes) -> None:
    """trajectory.csv."""
    from kinolab.trajectory import read_csv

    with suppress(InputError):
        read_csv(_put("trajectory.csv", data), *NAMES)


@_target(mutation.of_csv, "runs", "trajectory", "verification", seconds=2 * MOST_SECONDS)
def read_checked_run(data: bytes) -> None:
    """``plan check`` of a run, whose trajectory is simulated anew."""
    from kinolab.runs import check_run

    folder = home() / "checked"
    if not folder.exists():
        shutil.copytree(CORPUS / "run_folder", folder)
        _put("checked/report.json", (CORPUS / "report" / "solved").read_bytes())
    _put("checked/trajectory.csv", data)
    with suppress(InputError):
        check_run(folder)


@_target(mutation.of_csv, "analyze")
def read_inputs_csv(data: bytes) -> None:
    """The inputs of ``plan simulate``."""
    from kinolab.analyze.simulate import read_inputs

    with suppress(InputError):
        read_inputs(_put("inputs.csv", data), coin().model)


@_target(mutation.of_npz, "runs", "trajectory")
def read_trajectory_npz(data: bytes) -> None:
    """trajectory.npz, which says the same as trajectory.csv or not."""
    from kinolab.runs.folder import NPZ, _same_in_npz
    from kinolab.trajectory import read_csv

    path = _put("npz/trajectory.csv", (CORPUS / "trajectory_csv" / "short").read_bytes())
    _put(f"npz/{NPZ}", data)
    _same_in_npz(path.parent, read_csv(path, *NAMES))


@_target(
    mutation.of_json(
        "assets", "diagnosis", "sentences", "scenario_file", "verification", "margin", "status",
        "search", "statistics", "checks", "message", "system", "planner", "seed", "goal_distance",
    ),
    "runs", "show",
)  # fmt: skip
def read_report(data: bytes) -> None:
    """report.json of a run, what is asked of it before another is written, and its page."""
    from kinolab.runs.certificate_file import unchanged
    from kinolab.runs.folder import _recorded_assets, read_run, replaced_scenario
    from kinolab.show.page.data import page_data
    from kinolab.show.scene.scenes import content_of

    folder = home() / "run"
    if not folder.exists():
        shutil.copytree(CORPUS / "run_folder", folder)
    _put("run/report.json", data)
    _recorded_assets(folder)
    replaced_scenario(folder, coin())
    with suppress(InputError):
        run = read_run(folder)
        unchanged(folder, run.problem, run.report)
        data, _ = page_data(content_of(run.problem, run.trajectory, run.report, run.graph))
        utf_8(json.dumps(data, allow_nan=False, ensure_ascii=False))


@_target(mutation.of_json("files", "checks", "margin", "passed"), "runs.certificate_file")
def read_certificate(data: bytes) -> None:
    """certificate.json of a run, whose report believes it."""
    from kinolab.runs.certificate_file import CERTIFICATE, unchanged

    folder = home() / "certified"
    if not folder.exists():
        shutil.copytree(CORPUS / "run_folder", folder)
    _put(f"certified/{CERTIFICATE}", data)
    digest = hashlib.sha256(data).hexdigest()
    unchanged(folder, coin(), {"assets": {"machine.json": "0"}, "certificate": digest})


@_target(mutation.of_npz, "search.graph")
def read_search_npz(data: bytes) -> None:
    """search.npz of a run."""
    from kinolab.search.graph import read_graph

    with suppress(InputError):
        read_graph(_put("search.npz", data), NAMES[0])


@_target(mutation.of_npz, "search.roadmap")
def read_roadmap(data: bytes) -> None:
    """The file of a roadmap."""
    from kinolab.search.roadmap import load_roadmap

    with suppress(InputError):
        load_roadmap(_put("roadmap.npz", data), coin())


# --- meshes ---


def _mesh(kind: str, data: bytes, materials: bytes = b"") -> None:
    from kinolab.world.obstacles.obstacle import mesh_obstacle

    path = _put(f"meshes/mesh.{kind}", data)
    _put("meshes/mesh.mtl", materials)
    with suppress(InputError), _own_cache():
        mesh_obstacle("mesh", path.name, path.parent)
        mesh_obstacle("mesh", path.name, path.parent)  # from the cache


MESHES = "world.meshes", "world.obstacles"


@_target(mutation.of_bytes(b"facet normal", b"vertex", b"endloop", b"solid", b"endsolid"), *MESHES)
def read_mesh_stl(data: bytes) -> None:
    """STL, binary or text."""
    _mesh("stl", data)


@_target(mutation.of_bytes(b"v ", b"f ", b"vt ", b"vn ", b"usemtl a\n", b"mtllib mesh.mtl\n",
                           b"o a\n",
                           b"1/1/1", b"-1", b"g a\n", b"\\\n"), *MESHES)  # fmt: skip
def read_mesh_obj(data: bytes) -> None:
    """OBJ, with the materials that it may name."""
    _mesh("obj", data, b"newmtl a\nKd 1 0 0\n")


@_target(
    mutation.of_bytes(b"newmtl a\n", b"Kd ", b"map_Kd x.png", b"illum", b"Ns ", b"d "), *MESHES
)
def read_materials(data: bytes) -> None:
    """The materials of an OBJ."""
    text = b"mtllib mesh.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\n"
    _mesh("obj", text + b"f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", data)


@_target(mutation.of_bytes(b"element vertex ", b"element face ", b"property list uchar int a\n",
                           b"property float x\n", b"format ascii 1.0\n", b"end_header\n",
                           b"format binary_little_endian 1.0\n", b"double",
                           b"property uchar red\n"),
         *MESHES)  # fmt: skip
def read_mesh_ply(data: bytes) -> None:
    """PLY, binary or text."""
    _mesh("ply", data)


@_target(mutation.of_bytes(b"OFF\n", b"COFF\n", b"3 0 1 2\n", b"4 0 1 2 3\n", b"#"), *MESHES)
def read_mesh_off(data: bytes) -> None:
    """OFF."""
    _mesh("off", data)


def _of_glb(data: bytes, random: Random) -> bytes:
    """Change the JSON of a GLB in its tree, or any of its bytes."""
    if data[:4] != b"glTF" or len(data) < 20 or random.random() < 0.2:
        return mutation.of_bytes(b"glTF", b"JSON", b"BIN\x00")(data, random)
    length = int.from_bytes(data[12:16], "little")
    words = ("nodes", "meshes", "children", "matrix", "mesh", "accessors", "bufferViews", "count",
             "byteOffset", "byteStride", "componentType", "type", "MAT4", "SCALAR", "VEC3",
             "scenes",
             "extensions", "images", "uri", "sparse", "indices", "POSITION", "mode", "materials",
             "scale", "rotation", "data:,x", "file:///etc/passwd", "buffers",
             "byteLength")  # fmt: skip
    tree = mutation.of_json(*words)(data[20 : 20 + length], random)
    return glb(tree, data[20 + length :])


def glb(tree: bytes, rest: bytes) -> bytes:
    """Return a GLB of JSON and of what follows it."""
    tree += b" " * (-len(tree) % 4)
    head = b"glTF" + (2).to_bytes(4, "little") + (20 + len(tree) + len(rest)).to_bytes(4, "little")
    return head + len(tree).to_bytes(4, "little") + b"JSON" + tree + rest


@_target(_of_glb, *MESHES)
def read_mesh_glb(data: bytes) -> None:
    """GLB."""
    _mesh("glb", data)


@_target(mutation.of_bytes(b"<mesh>", b"<triangles count='1'>", b"<p>0 1 2</p>", b"<float_array>",
                           b"<input semantic='VERTEX' source='#a' offset='0'/>", b"&lol;",
                           b"<!DOCTYPE a [<!ENTITY lol 'lol'>]>", b"<up_axis>", b"<unit meter='"),
         *MESHES)  # fmt: skip
def read_mesh_dae(data: bytes) -> None:
    """DAE, also called COLLADA."""
    _mesh("dae", data)


# --- maps and clouds ---

SENSED = ("world.sensed",)


@_target(mutation.of_bytes(b"mode: scale\n", b"negate: 1\n", b"origin: [0, 0, 0]\n", b"image: ",
                           b"&a [*a]", b".nan", b"1e999", b"resolution: "), *SENSED)  # fmt: skip
def read_map_yaml(data: bytes) -> None:
    """The description of a map, beside a picture."""
    from kinolab.world.sensed.map_file import with_image

    _put("maps/map.pgm", (CORPUS / "map_picture" / "grey").read_bytes())
    _map("yaml", data)
    with suppress(InputError):
        with_image(data, "other.pgm")


@_target(mutation.of_bytes(b"P5 3 2 255\n", b"P2\n", b"IHDR", b"IDAT", b"PLTE", b"tRNS"), *SENSED)
def read_map_picture(data: bytes) -> None:
    """A picture, as a map and as heights."""
    from kinolab.world.sensed.map_obstacles import relief_obstacle

    _map("png", data, resolution=0.5)
    path = home() / "maps" / "map.png"
    for limit in (None, 0.5):
        with suppress(InputError):
            relief_obstacle(
                "map", path.name, path.parent, relief=2.0, resolution=0.5, max_slope=limit
            )


@_target(mutation.of_bytes(b"type octile\n", b"height 3\n", b"width 4\n", b"map\n", b"@"), *SENSED)
def read_map_letters(data: bytes) -> None:
    """A map of Moving AI."""
    _map("map", data, resolution=0.5)


@_target(mutation.of_bytes(b"element vertex 4\n", b"property float x\n",
                           b"property list uchar int a\n", b"format ascii 1.0\n",
                           b"format binary_big_endian 1.0\n", b"nan"),
         *SENSED)  # fmt: skip
def read_cloud_ply(data: bytes) -> None:
    """A cloud in PLY."""
    _cloud("ply", data)


@_target(mutation.of_bytes(b"FIELDS x y z\n", b"SIZE 4 4 4\n", b"TYPE F F F\n", b"COUNT 1 1 9\n",
                           b"POINTS 4\n", b"DATA binary_compressed\n", b"DATA ascii\n"),
         *SENSED)  # fmt: skip
def read_cloud_pcd(data: bytes) -> None:
    """A cloud in PCD."""
    _cloud("pcd", data)


@_target(mutation.of_bytes(b"nan", b"1e999", b",", b"#", b"1 2 3\n"), *SENSED)
def read_cloud_xyz(data: bytes) -> None:
    """A cloud in lines of numbers."""
    _cloud("xyz", data)


def _cloud(kind: str, data: bytes) -> None:
    from kinolab.world.sensed.point_cloud import cloud_obstacle

    path = _put(f"clouds/cloud.{kind}", data)
    for voxel in (None, 0.5):
        with suppress(InputError):
            cloud_obstacle("cloud", path.name, path.parent, radius=0.1, voxel=voxel)


def _map(kind: str, data: bytes, resolution: float | None = None) -> None:
    from kinolab.world.sensed.map_obstacles import map_obstacles

    path = _put(f"maps/map.{kind}", data)
    with suppress(InputError):
        map_obstacles("map", path.name, path.parent, resolution=resolution)


# --- studies ---


@_target(
    mutation.of_toml(
        "schema", "title", "scenarios", "planners", "seeds", "improve", "check", "settings",
        "sweep",
        "sobol", "points", "ranges", "from", "to", "scale", "whole", "limits", "search",
        "iterations",
        "cpu", "memory", "case", "planner.goal_bias", "planner.name", "name", "label", "log",
    ),
    "studies",
)  # fmt: skip
def read_study(data: bytes) -> None:
    """The file of a study, and how many runs it asks for."""
    from kinolab.studies.expansion import run_count
    from kinolab.studies.study_file import read_study

    with suppress(InputError):
        run_count(read_study(_put("study/study.toml", data)))


def _of_lines(data: bytes, random: Random) -> bytes:
    lines = data.split(b"\n")
    at = random.randrange(len(lines))
    lines[at] = mutation.of_json("index", "solved", "settings", "status", "versions")(
        lines[at], random
    ).replace(b"\n", b" ")
    return b"\n".join(lines)


@_target(_of_lines, "studies")
def read_journal(data: bytes) -> None:
    """rows.jsonl, and what ``plan bench DIR`` makes of its rows."""
    from kinolab.studies.columns import table_of
    from kinolab.studies.journal import first_rows, read_rows

    with suppress(InputError):
        rows = first_rows(read_rows(_put("journal/rows.jsonl", data).parent))
        sum(row["solved"] for row in rows)
        table_of(rows)


@_target(_of_lines, "testing")
def read_answers(data: bytes) -> None:
    """What a notebook that is graded sends to its grader, message by message."""
    from kinolab.testing.answers.answers_from_afar import judge_one

    class Notebook:
        messages = iter(data.splitlines())

        def recv_bytes(self, _: int) -> bytes:
            return next(self.messages)

        def send_bytes(self, _: bytes) -> None:
            pass

    judge_one(cast(Any, Notebook()), lambda name, answer: {"exercise": name, "of": repr(answer)})


# --- caches: a damaged entry is made anew, and nobody sees an error ---


def _of_sealed(magic: bytes) -> mutation.Mutator:
    """Return a mutator of a cache file; half of them have a checksum that fits."""
    raw = mutation.of_bytes()

    def mutate(data: bytes, random: Random) -> bytes:
        if random.random() < 0.3:
            return raw(data, random)
        content = raw(data[len(magic) + 32 :], random)
        return magic + hashlib.sha256(content).digest() + content

    return mutate


@_target(_of_sealed(b"kinolab machine\n"), "dynamics.codegen")
def read_compiled_machine(data: bytes) -> None:
    """The cache of compiled machines."""
    from kinolab.dynamics.codegen.cache import COMPILED

    with _own_cache():
        COMPILED.path(["key"]).write_bytes(data)
        facts, code = COMPILED.get(["key"], lambda: ({"facts": 1}, b"code"))
        assert isinstance(facts, dict)
        assert isinstance(code, bytes)


@_target(_of_sealed(b"kinolab mesh\n"), "world.meshes")
def read_kept_mesh(data: bytes) -> None:
    """The cache of meshes."""
    from kinolab.world.meshes.mesh import load_mesh
    from kinolab.world.meshes.mesh_cache import MESHES

    path = _put("kept/post.off", POST.encode())
    with _own_cache():
        MESHES.path(["off", b"", POST.encode()]).write_bytes(data)
        mesh = load_mesh(path.name, root=path.parent)
        assert mesh.vertices.shape[1:] == (3,)
        assert mesh.faces.max() < len(mesh.vertices)


@_target(_of_sealed(b"kinolab distances\n"), "world.distances")
def read_distance_grid(data: bytes) -> None:
    """The cache of distance grids."""
    from kinolab.world.distances import distance_field_cache as grids

    obstacles, finest = coin().world.obstacles, 0.5
    with _own_cache():
        grids.GRIDS.path([grids.digest(obstacles), repr(finest)]).write_bytes(data)
        grid = grids.cached_distance_field(obstacles, finest)
        assert grid.distance.ndim == 3


PLAIN = (None, 1, "x", [], {}, (), (1, 2), (None, {}), ("stamp", {"key": "name"}), {"a": 1}, b"x")


def _of_pickles(magic: bytes, head: bytes = b"") -> mutation.Mutator:
    """Return a mutator of a cache of pickles: damaged, or of other data; they are never mutated."""
    raw = mutation.of_bytes()

    def mutate(data: bytes, random: Random) -> bytes:
        if random.random() < 0.5:
            damaged = raw(data, random)
            return damaged if damaged != data else data[:-1]
        content = head + pickle.dumps(random.choice(PLAIN))[: random.choice((None, None, 3, -1))]
        return magic + hashlib.sha256(content).digest() + content

    return mutate


@_target(_of_pickles(b"kinolab described\n"), "dynamics.codegen")
def read_record(data: bytes) -> None:
    """The cache of machines' facts."""
    from kinolab.dynamics.codegen.cache import key_of
    from kinolab.dynamics.model.model import DESCRIBED, Model

    with _own_cache():
        DESCRIBED.path([key_of("content")]).write_bytes(data)
        found = Model.kept("content", lambda: None)  # type: ignore[arg-type, return-value]
        assert found is None or isinstance(found, Model)


@_target(_of_pickles(b"kinolab compiled loop 1\n"), "numerics.jit_cache")
def read_compiled_loop(data: bytes) -> None:
    """The cache of compiled loops: its index, and one entry."""
    from kinolab.numerics.jit_cache import _SealedFiles

    folder = home() / "loops"
    folder.mkdir(exist_ok=True)
    stamp = (1.0, 2)
    files = _SealedFiles(str(folder), "loop", stamp)
    Path(files._index_path).write_bytes(data)
    files.load("key")
    for path in folder.iterdir():
        path.unlink()
    files.save("key", "code")
    for path in folder.glob("*.nbc"):
        path.write_bytes(data)
    assert files.load("key") in (None, "code")
