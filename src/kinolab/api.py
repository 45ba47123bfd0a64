"""The public API: ``load``, ``Problem`` and ``Plan``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np

from kinolab import loading
from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.scenario import sound
from kinolab.solve.plan import PlanResult

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from kinolab.analyze.examine import Examination
    from kinolab.analyze.simulate import Policy
    from kinolab.dynamics import System
    from kinolab.numerics.arrays import Array
    from kinolab.runs import Run
    from kinolab.search.ompl import OmplSetup
    from kinolab.solve.replanning.replanner import Replanner
    from kinolab.trajectory import Trajectory
    from kinolab.verification.tube.claim import Claim


def load(source: str | Path | Mapping[str, Any], *, overrides: Sequence[str] = ()) -> Problem:
    """Read a scenario and build its problem.

    Args:
        source: Path of a TOML file, the name of a built-in scenario, the path of an environment
            of dynobench, a YAML file, or of a problem of OMPL.app, a .cfg file, or a table with the
            keys of a scenario file. In a table ``system`` may be a System, ``schema`` and ``title``
            may be left out, and relative paths start at the working directory.
        overrides: ``KEY=VALUE`` strings that replace keys of the file. Where one selects another
            planner, the settings of the file's planner are dropped.

    Raises:
        InputError: With every mistake that was found.
    """
    return Problem.of(loading.load(source, overrides=overrides))


def simulate(
    machine: System | PlanningTask | str | Path,
    policy: Policy | None = None,
    *,
    duration: float = 5.0,
    start: Mapping[str, Any] | ArrayLike | None = None,
    step: float | None = None,
) -> Trajectory:
    """Let a machine move under a policy, without a planner, a goal or obstacles.

    Args:
        machine: A system, a problem, or what ``plan simulate`` takes: a system's name, a scenario
            or ``machine.py:function``.
        policy: A function of time in [s] and state (nx,) that returns inputs, as an array (nu,), a
            number where there is one, or a table by name whose absentees are 0. They are held for a
            step, within their limits or not. Without a policy all inputs are 0.
        duration: In [s].
        start: Values by name, or a state (nx,); the problem's, or at rest, when left out.
        step: How long inputs are held, in [s]; the problem's, or 0.05, when left out.

    Returns:
        The motion, integrated as the verifier does it.

    Raises:
        InputError: If an argument does not fit, or the start violates a constraint.
        DivergedError: If the motion cannot be integrated to its end.
    """
    from kinolab.analyze import simulate as by_itself
    from kinolab.dynamics.language.mechanism import Mechanism

    require_fit("simulate machine", Mechanism | PlanningTask | str | Path, machine)
    require_fit("simulate duration", float, duration)
    if not (policy is None or callable(policy)):
        what, remedy = f"it is {policy!r}.", "Give a function of time and state, or None."
        raise InputError([Mistake("simulate policy", what, remedy)])
    by_name = start if isinstance(start, Mapping) else None
    problem = _to_simulate(machine, by_name, step)
    if start is not None and by_name is None:
        x = np.asarray(start, dtype=float)
        if x.shape != problem.start.shape:
            names = ", ".join(problem.model.state_names)
            what = f"it has shape {x.shape}, not {problem.start.shape}."
            raise InputError([Mistake("simulate start", what, f"The states are {names}.")])
        problem = replace(problem, start=x)
    return by_itself.simulate(problem, duration, policy)


def examine(machine: System | PlanningTask | str | Path) -> Examination:
    """Say what a machine does, what is odd about it, and whether the laws of mechanics hold.

    Args:
        machine: A system, a problem, or what ``plan examine`` takes: a system's name, a scenario or
            ``machine.py:function``.

    Returns:
        ``.sentences``, ``.remarks``, ``.laws`` and ``.verdict``; ``print`` shows all of it, and so
        does a notebook.

    Raises:
        InputError: If there is no such machine, or it cannot be derived.
    """
    from kinolab.analyze.examine import examine as examined
    from kinolab.dynamics import System
    from kinolab.dynamics.language.mechanism import Mechanism

    require_fit("examine machine", Mechanism | PlanningTask | str | Path, machine)
    if isinstance(machine, Mechanism):
        return examined(System.of(machine))
    if isinstance(machine, PlanningTask):
        scenario, system = machine.scenario, machine.system
    else:
        scenario = loading.find_scenario(str(machine))
        system = loading.find_system(scenario)
    file, system = loading.file_of_machine(scenario), System.of(system)
    start = loading.stated_start(scenario, system)
    return examined(system, scenario.integration, file=file, start=start)


def _to_simulate(
    machine: System | PlanningTask | str | Path, start: Mapping[str, Any] | None, step: float | None
) -> PlanningTask:
    """Return the problem of a machine, from a start and with a step of one's own."""
    changes: dict[str, Any] = {} if step is None else {"integration.step": step}
    if isinstance(machine, PlanningTask) and start is None and not changes:
        return machine
    if isinstance(machine, PlanningTask):
        scenario = machine.scenario
    elif isinstance(machine, str | Path):
        scenario = loading.find_scenario(str(machine))
    else:
        scenario = sound(*loading.read_table({"system": machine}))
    if start is not None:
        changes["start"] = {**scenario.start, **start}
    changed = loading.read_changed(scenario, changes, by="simulate")
    return loading.built(*changed, planning=False)


def read_run(folder: str | Path) -> Run:
    """Read a finished run back from its files alone; no code in it is run.

    Args:
        folder: As ``plan.save`` or the command line wrote it.

    Returns:
        ``.problem``, ``.trajectory``, ``.report`` and ``.graph``.

    Raises:
        InputError: If a file is missing or damaged.
    """
    from kinolab import runs

    require_fit("read_run folder", str | Path, folder)
    run = runs.read_run(Path(folder))
    return replace(run, problem=Problem.of(run.problem))


class Problem(PlanningTask):
    """A planning problem that can be changed, solved, shown and handed to OMPL."""

    @classmethod
    def of(cls, task: PlanningTask) -> Self:
        """Return a planning task with these conveniences."""
        return cls(**{entry.name: getattr(task, entry.name) for entry in fields(task)})

    def replace(self, changes: Mapping[str, Any] | None = None, /, **further: Any) -> Self:
        """Return the problem of the same scenario with some of its keys changed.

        ``problem.replace(**{"start.x": 1.0, "planner.name": "rrt"})``. It is built anew from its
        scenario. Where another planner is named, the settings of the former one are dropped.

        Args:
            changes: Values by the scenario's dotted keys; entries of lists count from 1, or go by
                their names: ``world.obstacle.crate.position``. ``start`` may be a state (nx,).
            further: The same by keyword.

        Raises:
            InputError: With every mistake that was found.
        """
        require_fit("replace changes", Mapping[str, Any] | None, changes)
        values = {**(changes or {}), **further}
        if not isinstance(start := values.get("start", {}), Mapping):
            values["start"] = loading.start_table(self.model, start)
        changed = loading.read_changed(self.scenario, values)
        return self.of(loading.built(*changed))

    def with_obstacle(
        self,
        name: str = "",
        *,
        box: Sequence[float] | None = None,
        sphere: float | None = None,
        cylinder: Sequence[float] | None = None,
        capsule: Sequence[float] | None = None,
        mesh: str | Path | None = None,
        position: Sequence[float] = (0.0, 0.0, 0.0),
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        **of_mesh: Any,
    ) -> Self:
        """Return the problem with one more obstacle, as ``[[world.obstacle]]`` describes it.

        Args:
            name: What messages call it; made of its shape and the count when left out.
            box: Full edges along x, y and z in [m].
            sphere: Radius in [m].
            cylinder: Radius and length in [m].
            capsule: Radius and length in [m], of the cylinder between two halves of a ball.
            mesh: Path of a mesh file, relative to the scenario's folder and below it.
            position: Of its centre, or of a mesh file's origin, in [m].
            rpy: Roll, pitch and yaw in [rad].
            of_mesh: ``scale``, ``up`` and ``solid``, of a mesh.

        Raises:
            InputError: With every mistake that was found.
        """
        round_ = {"sphere": sphere, "cylinder": cylinder, "capsule": capsule}
        shapes = {"box": box, **round_, "mesh": mesh}
        given = {key: value for key, value in shapes.items() if value is not None}
        entry = {"position": position, "rpy": rpy, **given, **of_mesh}
        named = {"name": name, **entry} if name else entry
        return self.of(loading.built(*loading.read_with_obstacle(self.scenario, named)))

    def with_predicate(self, holds: Callable[[Array], bool]) -> Self:
        """Return the problem whose goal holds only where a function of the state says so, too.

        Searches end, and plans are verified, by asking it; nothing is known of where it leads. It
        is in no file: who checks a run that was saved checks all else. ``replace`` leaves it out.

        Args:
            holds: Takes a state, shape (nx,), in the order of ``problem.model.state_names``.

        Raises:
            InputError: If it cannot be called.
        """
        if not callable(holds):
            what, remedy = f"it is {holds!r}.", "Give a function of the state."
            raise InputError([Mistake("with_predicate holds", what, remedy)])
        goal = self.goal.changed(lambda one: replace(one, predicate=holds))
        return replace(self, goal=goal)

    def solve(
        self,
        planner: str | None = None,
        seed: int | None = None,
        time_limit: float | None = None,
        *,
        max_iterations: int | None = None,
        improve: float | Literal["auto"] | None = None,
        guess: Trajectory | None = None,
        jobs: int = 1,
        anytime: bool = False,
        optimize: bool = True,
        **settings: Any,
    ) -> Plan:
        """Search for a plan, re-simulate it and verify it.

        Args:
            planner: Name of the planner, or ``file.py:Class`` relative to the working directory;
                the scenario's when left out.
            seed: Random seed; the scenario's when left out.
            time_limit: Of the search, in [s]; the scenario's when left out.
            max_iterations: Of the search; the scenario's when left out.
            improve: Work on making the motion exact and shorter, in [s]; the scenario's when left
                out, 0 for none, ``"auto"`` for more where the motion is long.
            guess: A motion of this machine, such as the plan of a world that has changed since:
                where it can be made to fit, nothing is searched for.
            jobs: Number of searches at once, each with a seed of its own; the first plan wins.
            anytime: Whether to go on with further seeds until the time limit; the shortest wins.
            optimize: Whether to make the motion exact and shorter at all; without it a planner may
                use ``improve`` itself.
            settings: Of the planner, and what ``kinolab.solve.solve`` calls during the search:
                ``progress``, ``watch`` and ``improved``.

        Raises:
            EndpointError: If the start or the goal is infeasible.
            InputError: If the planner or a setting does not exist, or a value does not fit.
        """
        from kinolab.solve import solve

        plan = solve(
            self,
            planner,
            seed,
            time_limit,
            max_iterations=max_iterations,
            improve=improve,
            guess=guess,
            jobs=jobs,
            anytime=anytime,
            optimize=optimize,
            **settings,
        )
        return Plan(**vars(plan), problem=self)

    def replanner(
        self,
        plan: PlanResult | None = None,
        *,
        deadline: float = 0.1,
        period: float = 0.1,
        tolerance: float = 0.01,
    ) -> Replanner:
        """Return what plans again and again while the machine moves.

        ``.replan(start, elapsed, obstacles)`` answers before a deadline how it goes on from the
        state in which it will be then, in a world where obstacles have moved. All that it needs is
        compiled when this returns.

        Args:
            plan: The first plan; that of ``solve()`` when left out.
            deadline: Of each answer, in [s].
            period: From the beginning of one answer to that of the next, in [s].
            tolerance: Of each state's scale: so far where the machine is may be from where it
                should be, and its motion be kept for its own control to follow.

        Raises:
            InputError: If no first plan is found, or an argument does not fit.
        """
        from kinolab.solve.plan import make_planner
        from kinolab.solve.replanning.replanner import Proof, Replan, replanner

        for name, value in {"deadline": deadline, "period": period}.items():
            require_fit(f"replanner {name}", float, value)
            if not 0.0 < value < math.inf:
                what, remedy = f"it is {value:g} s.", "Give seconds, more than 0."
                raise InputError([Mistake(f"replanner {name}", what, remedy)])
        require_fit("replanner tolerance", float, tolerance)
        if not 0.0 <= tolerance < math.inf:
            what, remedy = f"it is {tolerance:g}.", "Give a part of a state's scale, at least 0."
            raise InputError([Mistake("replanner tolerance", what, remedy)])
        plan = plan or self.solve()
        if plan.status != "solved" or plan.trajectory is None or plan.certificate is None:
            what = f"there is no plan to begin with: {plan.message}"
            raise InputError([Mistake("replanner plan", what, "Solve the problem first.")])
        proof = Proof(0.0, plan.trajectory.duration, plan.certificate)
        first = Replan("searched", self, plan.trajectory, (proof,))
        searcher = make_planner(self, None, {})
        return replanner(
            self,
            searcher,
            first,
            deadline=deadline,
            period=period,
            seed=plan.seed,
            tolerance=tolerance,
        )

    def _repr_html_(self) -> str:
        """Show world, start and goal in 3D in a notebook."""
        from kinolab.show.view import notebook_frame

        return notebook_frame(self, None)

    def to_ompl(self) -> OmplSetup:
        """Return the problem as OMPL objects, for OMPL's control planners.

        ``.space_information`` and ``.problem_definition`` are ready to use; after a planner's
        ``solve``, ``.trajectory()`` returns what it found, or ``.trajectory(path)`` another path.
        """
        from kinolab.search.ompl import OmplSetup

        return OmplSetup(self)


@dataclass(frozen=True, repr=False)
class Plan(PlanResult):
    """The result of planning, with the problem it solves.

    Attributes:
        problem: The problem it solves; a notebook shows the plan in its world.
    """

    problem: PlanningTask | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        """Name its status and what found it; ``print`` shows more."""
        motion = "" if self.duration is None else f", motion of {self.duration:.2f} s"
        return f"<Plan {self.status}: {self.planner}, seed {self.seed}{motion}>"

    def __str__(self) -> str:
        """Summarise it in ten lines at most."""
        if self.problem is None:
            return f"{self.status}: {self.message}"
        from kinolab.runs.plan_summary import plan_text

        return plan_text(self.problem, self)

    def prove(
        self,
        percent: float = 5.0,
        parameters: Sequence[str] = (),
        *,
        noise: float = 0.0,
        disturbance: float = 0.0,
    ) -> Claim:
        """Prove that every machine within some bounds carries the plan out, or how far it is so.

        Args:
            percent: By how much of its value each parameter may be off.
            parameters: Which are uncertain; as ``plan prove`` chooses them when left out.
            noise: By how much a measurement is off at most, as a share of the state's scale.
            disturbance: By how much an input is off at most, as a share of its range.

        Returns:
            ``.proved``, ``.share`` of what was asked that is proved, and ``.proof`` with its tube;
            ``print`` shows what it says.

        Raises:
            InputError: If there is no motion, or no proof for such a machine or such bounds.
        """
        from kinolab.verification.tube.claim import claimed
        from kinolab.verification.tube.proof import Prover
        from kinolab.verification.tube.uncertainty import (
            Uncertainty,
            kept_by_default,
            varied_by_default,
        )

        require_fit("prove percent", float, percent)
        if self.problem is None or self.trajectory is None:
            what = "this plan has no motion, or does not know its problem."
            raise InputError([Mistake("prove", what, "Prove what problem.solve(…) returned.")])
        kept = kept_by_default(self.problem.system)
        varied = tuple(parameters) or varied_by_default(self.problem, kept)
        asked = Uncertainty(dict.fromkeys(varied, percent / 100.0), noise, disturbance)
        asked.require(self.problem)
        return claimed(Prover(self.problem, self.trajectory), asked)

    def save(self, folder: str | Path) -> Path:
        """Write the folder of a run, as the command line does but for its pictures.

        ``kinolab.read_run`` reads it; ``plan check``, ``plan view`` and ``plan video`` take it.
        Files of an earlier run in the folder are replaced.

        Args:
            folder: Made where it is missing.

        Returns:
            The folder.

        Raises:
            InputError: If the plan does not know its problem, or the folder cannot be written or
                has a scenario of its own.
        """
        from kinolab.runs import require_place, write_run

        require_fit("save folder", str | Path, folder)
        if self.problem is None:
            what = "this plan does not know its problem."
            raise InputError([Mistake("save", what, "Save what problem.solve(…) returned.")])
        require_place(Path(folder))
        write_run(Path(folder), self.problem, self)
        return Path(folder)

    def _repr_html_(self) -> str | None:
        """Show it in 3D in a notebook; as text where its world is unknown."""
        if self.problem is None:
            return None
        from kinolab.show.view import notebook_frame

        return notebook_frame(self.problem, self)
