"""The grade of a project: a machine of somebody's own, and a plan for it.

Half of the points are for the machine, if it is what was asked for: one that is wrong obeys the
laws of mechanics as well. The other half are for what is planned with it, right or wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from kinolab.dynamics import System
from kinolab.errors import KinolabError
from kinolab.loading import build_problem, file_of_machine, find_scenario, find_system, load
from kinolab.problem import PlanningTask
from kinolab.scenario import Scenario
from kinolab.solve.plan import PlanResult
from kinolab.testing.exercises import Mark
from kinolab.testing.grade_report import Report
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, verify

RIGHT, RICH, SOLVED, PROVED, NEAR = 4, 2, 3, 2, 1  # points of a project
SOUND, MOVES = "nothing is wrong with the machine", "it moves as was asked"
PLAN_FOUND, PROOF, CENTRE = "a plan is found", "it is proved", "it ends in the goal's centre"

Told = Callable[[str], None]


def project_report(what: str, against: str | None, due: bool, told: Told) -> Report:
    """Grade a project.

    Args:
        against: What was asked for: a scenario or a machine, as ``plan simulate`` takes them.
        due: Whether reasons say what would be right.
        told: Called with what is being done.

    Raises:
        InputError: If there is no such scenario, or its machine is none.
    """
    scenario = find_scenario(what)
    told("the machine is examined")
    system = System.of(find_system(scenario))
    asked = None if against is None else build_problem(find_scenario(against), planning=False)
    faults = [*_faults(system, scenario, asked)]
    if asked is not None:
        told("its motions are compared with those that were asked for")
        faults += _differences(asked, scenario, due)
    richer = not faults and any(_richer(system))
    poor = "it generalises it in no way." if not faults else "that counts for a right machine."
    machine = (
        _part(SOUND if asked is None else MOVES, RIGHT, not faults, f"{'; '.join(faults)}."),
        _part("more than the rolling disk", RICH, richer, poor),
    )
    try:
        return Report(what, (*machine, *_planned(load(what), asked, told)))
    except KinolabError as error:
        return Report(what, (*machine, *_unplanned(" ".join(str(error).split()))))


def _faults(system: System, scenario: Scenario, asked: PlanningTask | None) -> Iterator[str]:
    """Yield what ``plan examine`` has against a machine, and not against the one asked for."""
    known = {} if asked is None else _remarks(System.of(asked.system), asked.scenario)
    remarks = _remarks(system, scenario)
    yield from (told.removesuffix(".") for law, told in remarks.items() if law not in known)


def _remarks(system: System, scenario: Scenario) -> dict[str, str]:
    """Return what ``plan examine`` has against a machine: sentences by what they are about.

    What the machine says it expects is for its author's eyes: in a grade it counts.
    """
    from kinolab.analyze.examine import examine

    place = file_of_machine(scenario)
    found = examine(system.changed(expected=()), scenario.integration, file=place)
    broken = {law.law: str(law) for law in found.broken}
    return {one.title: str(one) for one in found.remarks} | broken


def _differences(asked: PlanningTask, scenario: Scenario, due: bool) -> Iterator[str]:
    """Yield how a machine moves otherwise than asked, after what may explain it."""
    from kinolab.testing.answers.asked_motion import differences
    from kinolab.testing.answers.asked_parts import explanations

    try:
        given = build_problem(scenario, planning=False)
    except KinolabError as error:
        yield f"it cannot be simulated: {' '.join(str(error).split())}".removesuffix(".")
        return
    found = differences(asked, given)
    for one in (*explanations(asked, given), *found) if found else ():
        yield one.said(due).removesuffix(".")


def _richer(system: System) -> Iterator[bool]:
    from kinolab.analyze.describe.description import describe
    from kinolab.analyze.describe.each_mode import in_each_mode

    for _, machine in in_each_mode(system):
        yield any(one.shown for one in describe(machine).generalisations)


def _planned(problem: PlanningTask, asked: PlanningTask | None, told: Told) -> Iterator[Mark]:
    """Yield what the plan for a project is worth; where it starts in the goal, that is nothing."""
    from kinolab.problem.goal_entries import goal_entries
    from kinolab.solve import solve

    entries = goal_entries(problem, problem.start)
    if entries and all(entry.reached for entry in entries):
        yield from _unplanned("it starts in its goal.")
        return
    told(f"a plan is searched for, for {problem.scenario.planner.time_limit:g} s at most")
    plan = solve(problem)
    yield _part(PLAN_FOUND, SOLVED, plan.status == "solved", plan.message or plan.status)
    told("the plan is judged")
    task, certificate, motion = _judged(problem, asked, plan)
    failures = [str(one) for one in certificate.failures] if certificate else ["there is no plan."]
    yield _part(PROOF, PROVED, not failures, "; ".join(failures))
    off = [
        f"{one.name} is off by {one.error:.3g}{f' {one.unit}' if one.unit else ''}"
        for one in (goal_entries(task, motion.x[-1]) if motion else ())
        if one.error > 1e-3  # in SI units
    ]
    near = plan.status == "solved" and not off
    yield _part(CENTRE, NEAR, near, "; ".join(off) or "there is no plan.")


def _judged(
    problem: PlanningTask, asked: PlanningTask | None, plan: PlanResult
) -> tuple[PlanningTask, Certificate | None, Trajectory | None]:
    """Return by which problem a plan is judged, its certificate there, and its motion.

    That is the problem which was asked for, where it has a goal and the plan is one of its states
    and inputs by name; otherwise the project's own.
    """
    motion = plan.trajectory
    if asked is None or motion is None or not asked.goal.indices:
        return problem, plan.certificate, motion
    names, inputs = asked.model.state_names, asked.model.plant.control_names
    if motion.reference_names or {*names, *inputs} != {*motion.state_names, *motion.control_names}:
        return problem, plan.certificate, motion
    states, controls = map(motion.state_names.index, names), map(motion.control_names.index, inputs)
    x, u = motion.x[:, [*states]], motion.u[:, [*controls]]
    ordered = Trajectory(motion.t, x, u, names, inputs)
    return asked, verify(asked, ordered), ordered


def _unplanned(reason: str) -> Iterator[Mark]:
    wanted = ((PLAN_FOUND, SOLVED), (PROOF, PROVED), (CENTRE, NEAR))
    yield from (Mark(name, 0, points, reason) for name, points in wanted)


def _part(name: str, points: int, reached: bool, reason: str) -> Mark:
    return Mark(name, points if reached else 0, points, "" if reached else reason)
