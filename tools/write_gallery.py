"""Write docs/gallery.md from the machines and scenarios themselves.

    python tools/write_gallery.py [--check]
    python tools/write_gallery.py [--images [NAME ...]] [--plans [NAME ...]] [--seed N]

With --check nothing is written: it shows how the page differs and returns 1 if it does. With
--images scenarios are planned and filmed first: those named, or all that have no picture yet. The
motion of a film is kept in docs/plans, from which the site's build makes an interactive page. With
--plans motions are planned and kept without a film: those named, or all that have a film.
"""

from __future__ import annotations

import argparse
import difflib
import inspect
import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any
from unicodedata import normalize

import sympy

import kinolab
from kinolab import systems
from kinolab.dynamics import Attitude, Constraint, Coordinate, System
from kinolab.dynamics.lagrange.printing import SUPERSCRIPTS, one_line
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake
from kinolab.files import utf_8, write_whole
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import distance_by_unit, goal_entries
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import check_to_json, margin_to_json
from kinolab.scenario import builtin_scenarios, dynobench
from kinolab.show.film.film import staged
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.staging.script_writing import motion_script
from kinolab.show.page import page_html
from kinolab.show.view import content_of
from kinolab.trajectory import Trajectory, read_csv
from kinolab.verification import Certificate, verify
from kinolab.world import Obstacle

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, IMAGES, PLANS = DOCS / "gallery.md", DOCS / "images", DOCS / "plans"

# The order of the course; machines that are not in it follow by name.
COURSE = (
    *("pendulum", "rolling_disk", "crane", "two_cranes", "car", "diff_drive"),
    *("snakeboard", "biped", "submarine"),
    *("falling_disk", "unicycle", "motorcycle", "whipple"),
    *("helicopter", "snakeboard", "slip_steered", "submarine", "satellite", "satellite_two_wheels"),
)

FPS = 12.5  # frames per second of a film: 8/100 s each, which GIF can say
FRAMES = (80, 60, 40)  # of a film; fewer where it would be too large
LARGEST = 1_000_000  # [bytes] of a film
READABLE = 200  # operations of an expression that SymPy tidies in a moment
LONGEST = 700  # characters of a formula in a table

INTRODUCTION = """\
# Gallery

Every machine that comes with kinolab, and the scenario that plans for it. `python
tools/write_gallery.py` writes this page from the machines and scenarios themselves, so that it says
what they are. Units are SI and radians; `plan equations NAME` prints the equations of motion.

On the documentation site, a click on a film opens the [interactive page](page.md) of a plan, which
was verified when the site was built."""

KEPT = "A motion that was planned before; it was verified when this page was made."


def page() -> str:
    """Return the text of the page."""
    problems = [kinolab.load(name) for name in builtin_scenarios()]
    machines = [systems.get(name) for name in ordered(systems.names())]
    parts = [INTRODUCTION, overview(machines, problems)]
    for machine in machines:
        parts += machine_section(machine, planned_for(machine, problems))
    return normalize("NFC", "\n\n".join(parts) + "\n")


def ordered(names: Sequence[str]) -> list[str]:
    """Return machines in the order of the course."""
    return sorted(names, key=lambda name: (position_in_course(name), name))


def position_in_course(name: str) -> int:
    """Return the place of a machine in the course; the one after the last if it has none."""
    return COURSE.index(name) if name in COURSE else len(COURSE)


def planned_for(machine: System, problems: Iterable[PlanningTask]) -> list[PlanningTask]:
    """Return the problems of a machine, and of several of which it is the first."""
    return [problem for problem in problems if first_of(problem) == machine.name]


def first_of(problem: PlanningTask) -> str:
    """Return the name of a problem's machine, of several of the first."""
    several = problem.scenario.system.machines
    return str(next(iter(several.values())).name) if several else problem.system.name


def overview(machines: Iterable[System], problems: Sequence[PlanningTask]) -> str:
    """Return the table of contents."""
    rows = (
        (
            f"[{heading(machine.name)}](#{machine.name.replace('_', '-')})",
            *(configuration_space(machine), str(len(machine.all_constraints))),
            str(len(machine.inputs)),
            ", ".join(f"`{problem.name}`" for problem in planned_for(machine, problems)) or "–",
        )
        for machine in machines
    )
    return table("machine | configuration space | constraints | inputs | scenario", rows)


def machine_section(machine: System, problems: Iterable[PlanningTask]) -> Iterator[str]:
    """Yield the paragraphs and tables of a machine and of the scenarios that plan for it."""
    problems = list(problems)
    prose, source = description(machine.name)
    yield f"## {heading(machine.name)}"
    for problem in problems:
        yield from image(problem)
    yield from prose
    yield from machine_tables(machine)
    if source:
        yield f"Source: {source}"
    for problem in problems:
        yield from scenario_section(problem)
    if not problems and machine.name in dynobench.MACHINES:
        yield "Environments of a benchmark plan for it: see [dynobench.md](dynobench.md)."
    elif not problems:
        yield "No scenario plans for it yet."


def heading(name: str) -> str:
    """Return a machine's name as a heading: ``rolling_disk`` is Rolling disk."""
    return name.replace("_", " ").capitalize()


def description(name: str) -> tuple[list[str], str]:
    """Return what a machine's docstring says: its paragraphs, and its source or nothing."""
    factory = systems.maker(name)
    paragraphs = [" ".join(text.split()) for text in (inspect.getdoc(factory) or "").split("\n\n")]
    sources = [text for text in paragraphs if text.startswith("Source:")]
    prose = [text for text in paragraphs if text not in sources]
    return prose, " ".join(sources).removeprefix("Source:").strip()


def machine_tables(machine: System) -> Iterator[str]:
    """Yield the tables of a machine, each below its title; none where there is nothing to list."""
    for title, headings, rows in (
        ("Configuration", "coordinate | topology | unit | limits | speed", coordinates(machine)),
        ("Further states", "state | unit | limits", further_states(machine)),
        ("Inputs", "input | kind | unit | limits", inputs(machine)),
        ("Constraints", "constraint | held", constraints(machine)),
        ("Requirements on plans", "requirement | kept", requirements(machine)),
        ("Parameters", "parameter | value | unit", parameters(machine)),
    ):
        listed = list(rows)
        if listed:
            yield f"**{title}**"
            yield table(headings, listed)


def coordinates(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per coordinate."""
    for coordinate in machine.coordinates:
        limits, unit = "–", coordinate.unit
        if isinstance(coordinate, Coordinate):
            limits = interval(coordinate.lower, coordinate.upper)
        fastest = "–" if math.isinf(coordinate.speed) else f"{number(coordinate.speed)} {unit}/s"
        yield f"`{coordinate.name}`", topology(coordinate), unit, limits, fastest


def topology(coordinate: Coordinate | Attitude) -> str:
    """Return what a coordinate lives on."""
    return "SO(3)" if isinstance(coordinate, Attitude) else coordinate.topology


def configuration_space(machine: System) -> str:
    """Return the product of what the coordinates live on, such as ℝ² × 𝕊¹."""
    kinds = [topology(coordinate) for coordinate in machine.coordinates]
    factors = []
    for kind, letter in (("line", "ℝ"), ("circle", "𝕋"), ("SO(3)", "SO(3)")):
        count = kinds.count(kind)
        power = str(count).translate(SUPERSCRIPTS) if count > 1 else ""
        factors += [("𝕊¹" if (kind, count) == ("circle", 1) else letter) + power] if count else []
    return " × ".join(factors)


def further_states(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per state beyond positions and velocities."""
    for state in machine.states:
        yield f"`{state.name}`", units(state.unit), interval(*state.limits)


def inputs(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per input."""
    for entry in machine.inputs:
        kind = type(entry).__name__.lower()
        yield f"`{entry.name}`", kind, units(entry.unit), interval(*bounds_of(entry))


def constraints(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per constraint: w(q) q_dot = 0, or h(q) = 0."""
    for constraint in machine.all_constraints:
        text = formula(held(constraint))
        fits = len(text) <= LONGEST
        elsewhere = f"long; `plan equations {machine.name}` prints it"
        yield constraint.name, f"`{text} = 0`" if fits else elsewhere


def held(constraint: Constraint) -> sympy.Expr:
    """Return what a constraint holds at zero."""
    if isinstance(constraint, PositionConstraint):
        return constraint.position
    return constraint.velocity


def requirements(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per requirement."""
    for requirement in machine.all_requirements:
        yield requirement.name, f"`{one_line(requirement.margin)} ≥ 0`"


def parameters(machine: System) -> Iterator[Sequence[str]]:
    """Yield a row per parameter."""
    values = machine.parameter_values
    for parameter in machine.parameters:
        yield f"`{parameter.name}`", number(values[parameter.name]), units(parameter.unit)


def scenario_section(problem: PlanningTask) -> Iterator[str]:
    """Yield the paragraphs and tables of a scenario."""
    scenario = problem.scenario
    yield f"### {scenario.title}"
    yield f"```sh\nplan {problem.name}\n```"
    yield from changed_parameters(problem)
    yield "**In the way**"
    yield from in_the_way(problem)
    yield "**Goal**"
    yield table("what | target | tolerance | unit", goal(problem))
    yield "What the goal does not name is free."


def image(problem: PlanningTask) -> Iterator[str]:
    """Yield the picture of a scenario as Markdown, if there is one, and the way to its plan."""
    path = image_of(problem.name)
    if path is None:
        return
    picture = f"![{problem.scenario.title}]({path.relative_to(DOCS).as_posix()})"
    if not plan_of(problem.name).is_file():
        yield picture
        return
    # As HTML: a Markdown link to what is no document would be a broken one to Sphinx.
    link = f'<a class="plan" href="{plan_page(problem.name)}">'
    yield f"{link}{picture}</a>"
    yield f"{link}The plan as an interactive page</a>"


def image_of(name: str) -> Path | None:
    """Return the picture of a scenario, if there is one."""
    candidates = (IMAGES / f"{name}{suffix}" for suffix in (".gif", ".png"))
    return next((path for path in candidates if path.is_file()), None)


def changed_parameters(problem: PlanningTask) -> Iterator[str]:
    """Yield a sentence about the parameters whose defaults the scenario replaces."""
    if problem.scenario.system.machines:
        return
    defaults = systems.get(problem.system.name).parameter_values
    values = problem.system.parameter_values
    changed = [
        f"{name} = {number(values[name])}" for name in values if values[name] != defaults[name]
    ]
    if changed:
        yield f"With `{'`, `'.join(changed)}`."


def in_the_way(problem: PlanningTask) -> Iterator[str]:
    """Yield what a motion must stay clear of."""
    obstacles = [*map(obstacle_row, problem.world.obstacles), *movers(problem)]
    if obstacles:
        yield table("obstacle | shape | triangles", obstacles)
    limits = [f"`{axis}` {interval(*given)} m" for axis, given in problem.world.bounds.items()]
    sentences = ["The ground is the plane z = 0."] if problem.world.ground else []
    sentences += [f"The workspace: {', '.join(limits)}."] if limits else []
    moving = {body.name for body in problem.bodies if body.prescribed}
    apart = [pair for pair in problem.system.collisions if not moving & {*pair}]
    sentences += [f"{a} and {b} may not touch." for a, b in apart]
    sentences += keep_outs(problem)
    if sentences or not obstacles:
        yield " ".join(sentences) or "Nothing."


def movers(problem: PlanningTask) -> Iterator[Sequence[str]]:
    """Yield a row per obstacle that moves."""
    for entry in problem.scenario.world.obstacle:
        if entry.motion is not None:
            yield entry.name, f"{entry.kind}, which moves", "–"


def obstacle_row(obstacle: Obstacle) -> Sequence[str]:
    """Return an obstacle's name, its shape, and its triangles where it is a mesh."""
    if obstacle.primitive is not None:
        return obstacle.name, type(obstacle.primitive[0]).__name__.lower(), "–"
    file = obstacle.source.name if obstacle.source else "mesh"
    filling = "solid" if obstacle.solid else "surface only"
    return obstacle.name, f"`{file}`, {filling}", grouped(len(obstacle.faces))


def keep_outs(problem: PlanningTask) -> Iterator[str]:
    """Yield a sentence per cone that an axis must stay out of."""
    for cone in problem.keep_outs:
        body, angle = problem.bodies[cone.body].name, number(cone.half_angle)
        yield (
            f"The axis {vector(cone.axis)} of {body} stays {angle} rad away from the direction "
            f"{vector(cone.direction)}."
        )


def goal(problem: PlanningTask) -> Iterator[Sequence[str]]:
    """Yield a row per target, coordinates before rates."""
    target = problem.goal
    rows = {
        index: (f"`{problem.model.state_names[index]}`", number(value), number(tolerance))
        for index, value, tolerance in zip(
            target.indices, target.targets, target.tolerances, strict=True
        )
    }
    for attitude in target.parts:
        rows[attitude.part.first] = (
            *(f"`{attitude.part.name}`", f"quaternion {vector(attitude.target)}"),
            number(attitude.tolerance),
        )
    for index in sorted(rows):
        yield *rows[index], unit_of(problem.system, rows[index][0].strip("`"))
    yield from goals_of_bodies(problem)


def goals_of_bodies(problem: PlanningTask) -> Iterator[Sequence[str]]:
    """Yield a row per point and per axis of a body that has a target."""
    names = [body.name for body in problem.bodies]
    for point in problem.goal.points:
        what = f"point {vector(point.at)} of {names[point.body]}"
        yield what, vector(point.position), number(point.tolerance), "m"
    for axis in problem.goal.directions:
        what = f"axis {vector(axis.axis)} of {names[axis.body]}"
        yield what, f"along {vector(axis.target)}", number(axis.tolerance), "rad"


def unit_of(machine: Mechanism, name: str) -> str:
    """Return the unit of a coordinate, a rate or an auxiliary state, by its name."""
    known = {state.name: units(state.unit) for state in machine.states}
    for coordinate in machine.coordinates:
        known[coordinate.name] = coordinate.unit
        known[f"{coordinate.name}_dot"] = f"{coordinate.unit}/s"
        if isinstance(coordinate, Attitude):
            known |= {turn.name: "rad/s" for turn in coordinate.turn_rate}
    return known[name]


def table(headings: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; headings are given as ``a | b | c``."""
    titles = headings.split(" | ")
    lines = [titles, ["---"] * len(titles), *rows]
    escaped = ([cell.replace("|", r"\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in escaped)


def interval(lower: float, upper: float) -> str:
    """Return limits in words."""
    if math.isinf(lower) and math.isinf(upper):
        return "–"
    if math.isinf(lower):
        return f"at most {number(upper)}"
    if math.isinf(upper):
        return f"at least {number(lower)}"
    return f"{number(lower)} to {number(upper)}"


def number(value: float) -> str:
    """Return a number with up to six digits, and no minus in front of zero."""
    return f"{value + 0.0:g}"


def grouped(count: int) -> str:
    """Return a whole number with its digits in groups of three."""
    return f"{count:,}".replace(",", " ")


def vector(values: Sequence[float]) -> str:
    """Return numbers in parentheses."""
    return f"({', '.join(map(number, values))})"


def units(text: str) -> str:
    """Return a unit with raised exponents."""
    base, *exponents = text.split("^")
    return base + "".join(part[0].translate(SUPERSCRIPTS) + part[1:] for part in exponents)


def formula(expression: sympy.Expr) -> str:
    """Return an expression on one line, tidied where that is quick."""
    if expression.count_ops() < READABLE:
        expression = sympy.expand(sympy.trigsimp(sympy.expand(expression)))
    decimals = expression.atoms(sympy.Float)
    whole = {value: sympy.Integer(value) for value in decimals if float(value).is_integer()}
    return one_line(expression.xreplace(whole))


def plan_of(name: str) -> Path:
    """Return the file of a scenario's kept motion, whether there is one or not."""
    return PLANS / f"{name}.csv"


def plan_page(name: str) -> str:
    """Return where the site has the interactive page of a scenario's plan."""
    return f"gallery/{name}.html"


def kept_plans() -> list[str]:
    """Return the scenarios whose motion is kept."""
    return sorted(path.stem for path in PLANS.glob("*.csv"))


def write_plan_page(name: str, site: Path) -> Path:
    """Write the interactive page of a scenario's kept motion, which is verified anew.

    Args:
        name: Of the scenario.
        site: Folder of the site.

    Returns:
        The page's file.

    Raises:
        InputError: If there is no such scenario, the motion is another machine's, or it does not
            solve the scenario.
    """
    problem = kinolab.load(name)
    motion = kept_motion(problem)
    certificate = verify(problem, motion)
    if not certificate.passed:
        failures = "; ".join(map(str, certificate.failures))
        what = f"this motion does not solve the scenario {name}: {failures}."
        raise InputError([Mistake(f"docs/plans/{name}.csv", what)])
    content = content_of(problem, motion, facts(problem, motion, certificate))
    target = site / plan_page(name)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_whole(target, utf_8(page_html(content)))
    return target


def kept_motion(problem: PlanningTask) -> Trajectory:
    """Return the kept motion of a scenario.

    Raises:
        InputError: If its file is missing or damaged, or another machine's.
    """
    model, plant = problem.model, problem.model.plant
    references = () if plant is model else model.control_names
    path = plan_of(problem.name)
    return unwrapped(problem, read_csv(path, model.state_names, plant.control_names, references))


def facts(problem: PlanningTask, motion: Trajectory, certificate: Certificate) -> dict[str, Any]:
    """Return what a page says about a verified motion, by the keys of a report."""
    return {
        "status": "solved",
        "message": KEPT,
        "cost": motion.duration,
        "duration": motion.duration,
        "goal_distance_by_unit": distance_by_unit(goal_entries(problem, motion.x[-1])),
        "margin": margin_to_json(certificate),
        "verification": [check_to_json(check) for check in certificate.checks],
    }


def renew(name: str, seed: int, filmed: bool) -> bool:
    """Plan a scenario, keep the motion, and film it if asked; say how that went."""
    problem = kinolab.load(name)
    found = problem.solve(seed=seed)
    if found.trajectory is None or found.exit_code != 0:
        print(f"{name}: {found.status}, nothing is written. {found.message}")
        return False
    motion = found.trajectory
    PLANS.mkdir(exist_ok=True)
    motion.to_csv(plan_of(name))
    written = [plan_of(name)]
    if filmed:
        written.append(draw(problem, motion))
    sizes = ", ".join(f"{path.name} of {path.stat().st_size} bytes" for path in written)
    print(f"{name}: {motion.duration:.1f} s of motion, {sizes}", flush=True)
    return True


def draw(problem: PlanningTask, motion: Trajectory) -> Path:
    """Film a motion, with fewer frames where the film would be too large; return its file."""
    path = IMAGES / f"{problem.name}.gif"
    for frames in FRAMES:
        film(path, problem, motion, frames)
        if path.stat().st_size < LARGEST:
            break
    return path


def film(path: Path, problem: PlanningTask, trajectory: Trajectory, frames: int) -> None:
    """Write a motion as a film of about that many frames, as the scenario has its films."""
    speed = speed_for(trajectory.duration, frames)
    settings = problem.scenario.render.model_copy(update={"speed": speed})
    made = staged(motion_script(problem, trajectory, settings, fps=FPS))
    path.write_bytes(b"".join(gif_parts(made)))


def speed_for(duration: float, frames: int) -> float:
    """Return seconds of motion per second of film, a multiple of a half, for so many frames."""
    slowest = duration * FPS / (frames - 1)
    return max(1.0, math.ceil(2 * slowest) / 2)


def main() -> int:
    """Write the page, or check it; plan and draw pictures before if asked."""
    options = arguments()
    wanted = [*options.images, *(name for name in options.plans if name not in options.images)]
    done = [renew(name, options.seed, filmed=name in options.images) for name in wanted]
    text = page()
    if options.check:
        return 1 if differs(text) else 0
    PAGE.write_text(text, encoding="utf-8")
    return 0 if all(done) else 1


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Write docs/gallery.md.")
    parser.add_argument("--check", action="store_true", help="write nothing, show what differs")
    parser.add_argument("--images", nargs="*", metavar="NAME", help="plan and film scenarios first")
    parser.add_argument("--plans", nargs="*", metavar="NAME", help="plan scenarios first")
    parser.add_argument("--seed", type=int, default=1, help="of the plans")
    options = parser.parse_args()
    known = builtin_scenarios()
    unknown = {*(options.images or ()), *(options.plans or ())} - set(known)
    if unknown:
        parser.error(f"no such scenario: {', '.join(unknown)}; known: {', '.join(known)}")
    if options.images == []:
        options.images = [name for name in known if image_of(name) is None]
    if options.plans == []:
        options.plans = [name for name in known if image_of(name) is not None]
    options.images, options.plans = options.images or [], options.plans or []
    return options


def differs(text: str) -> bool:
    """Show how the page differs from what it should be, and say whether it does."""
    written = PAGE.read_text(encoding="utf-8") if PAGE.is_file() else ""
    before, after = written.splitlines(keepends=True), text.splitlines(keepends=True)
    sys.stdout.writelines(difflib.unified_diff(before, after, "docs/gallery.md", "as it should be"))
    return written != text


if __name__ == "__main__":
    sys.exit(main())
