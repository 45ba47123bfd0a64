"""Planning again and again while a machine moves: from where it is, in the world as it is now.

Each time the motion that it follows is kept as far as it holds. What no longer fits is closed by
motions between two of its states; only where that fails is the whole of it made anew, or searched
for. Nothing is offered that was not verified, together with a way to come to rest from it: where
nothing is by the deadline, the machine comes to rest as the last answer had proved it can. A motion
that was searched for is made shorter between questions, from where the machine is not yet.

Where: the loop that plans again.

Source: Hauser, On responsiveness, safety, and completeness in real-time motion planning, Autonomous
Robots 32, 2012; Fraichard, Asama, Inevitable collision states, Advanced Robotics 18, 2004.
"""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from threading import Event
from typing import NamedTuple

import numpy as np

from kinolab import trajopt
from kinolab.arguments import require_fit, require_numbers
from kinolab.concurrency.cancel import CancellationToken
from kinolab.concurrency.coroutine import Coroutine
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import Goal
from kinolab.problem.moved import with_obstacles_at
from kinolab.search import AbstractPlanner, Budget
from kinolab.simulation.reference import reference_motion
from kinolab.solve.attempt import motion, old_objects_left_alone
from kinolab.solve.plan import stream
from kinolab.solve.refinement import STILL_GAINING
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.segments import segment_problem
from kinolab.trajopt.nlp.options import SHORT
from kinolab.verification import Certificate, verify
from kinolab.verification.certificate import collision_check

# [s] of the first search, twice as long each time: what it looks for may have moved out of the way.
SEARCH = 1.0
# Of a state's scale, as MoveIt's allowed_start_tolerance: what a machine's own control makes up for
OFF = 0.01


@dataclass(frozen=True)
class Proof:
    """A certificate of one part of a motion, as a motion between its two ends.

    Attributes:
        begin: When the part begins, in [s].
        end: When it ends, in [s].
        certificate: What was verified.
    """

    begin: float
    end: float
    certificate: Certificate


@dataclass(frozen=True)
class Replan:
    """What a machine does from now on.

    Attributes:
        by: How it was made: ``kept``, ``mended``, ``shortened``, ``searched``, or ``stop`` where no
            motion into the goal was verified in time.
        problem: What it solves: from where the motion begins, in the world as it is now; a stop, in
            the world as it was when it was proved.
        trajectory: The motion, from time 0 on.
        proofs: Of its parts that are new, in order of time. What is between them was proved with an
            earlier answer, and is kept: there only what has moved since was held against it anew.
            Parts meet within 1e-6 of a state's scale.
        seconds: Of the clock, from question to answer.
        off: By how much of an entry's scale the state that was asked about differs at most from
            where the motion begins. Above the replanner's ``tolerance``, which only a stop can be,
            nothing is proved of where the machine is.
    """

    by: str
    problem: PlanningTask
    trajectory: Trajectory
    proofs: tuple[Proof, ...] = ()
    seconds: float = 0.0
    off: float = 0.0


class ProvedMotion(NamedTuple):
    """A motion that was found between questions, with its proof.

    Attributes:
        trajectory: The motion.
        certificate: Of it.
        stop: What follows it for a period, and comes to rest: proved, too.
    """

    trajectory: Trajectory
    certificate: Certificate
    stop: Replan | None = None


@dataclass
class Replanner:
    """Answers again and again how a machine goes on, each time before a deadline.

    Attributes:
        problem: The problem, with obstacles where they were last.
        searcher: Searches where nothing of the last motion can be kept.
        last: The last answer.
        deadline: Of an answer, in [s].
        period: From the beginning of one answer to that of the next, in [s]: so long the machine
            follows it, and then a stop where the next one is not there.
        seed: Of searches.
        tolerance: Of an entry's scale: so far a measured state may be from the motion that the
            machine follows. It is then kept as it is, for the machine's own control to follow.
        stop: What follows the last answer for a period, and comes to rest.
    """

    problem: PlanningTask
    searcher: AbstractPlanner
    last: Replan
    deadline: float
    period: float
    seed: int = 1
    tolerance: float = OFF
    stop: Replan = field(init=False)
    _way: Trajectory = field(init=False)  # the last motion into the goal
    _search: Coroutine[ProvedMotion | None] | None = None  # from where the stop ends
    _ready: tuple[Trajectory | None, Replan | None] = None, None  # a way, and how to stop from it
    _searches: int = 0  # since the last motion into the goal
    _moved: set[str] = field(default_factory=set)  # since that was proved
    _moved_meanwhile: set[str] = field(default_factory=set)  # since the search began
    _shorter: Coroutine[ProvedMotion | None] | None = None  # of the way, from further on
    _moved_while_shortening: set[str] = field(default_factory=set)
    _idle: Event = field(default_factory=Event)  # set while nothing is asked
    _pace: float = 0.0  # [s] of a verification, for each knot
    _asked: int = 0

    def __post_init__(self) -> None:
        """Begin with the first answer."""
        self.follow(self.last)

    def follow(self, answer: Replan) -> None:
        """Begin anew with an earlier answer; what has moved since then is held against it."""
        self.last = answer
        self._follow(answer, self._stopping(answer, math.inf) or answer)
        self._moved = {obstacle.name for obstacle in self.problem.world.obstacles}

    def replan(
        self,
        start: Array,
        elapsed: float,
        obstacles: Mapping[str, Sequence[float]] | None = None,
    ) -> Replan:
        """Return how the machine goes on.

        Args:
            start: Where it will be when the answer is there, shape (nx,), as measured or
                estimated: from now on until then it follows the last one.
            elapsed: When that is, in seconds since the last answer's motion began.
            obstacles: What has moved, by name: positions (3,) in [m].

        Raises:
            InputError: If an argument is no state, no time or no position, or there is no such
                obstacle.
        """
        begun = time.monotonic()
        start = require_numbers("replan start", start, self.problem.start.shape)
        require_fit("replan elapsed", float, elapsed)
        require_fit("replan obstacles", Mapping | None, obstacles)
        if not 0.0 <= elapsed < math.inf:
            what, remedy = f"it is {elapsed:g} s.", "Give the seconds since the last answer began."
            raise InputError([Mistake("replan elapsed", what, remedy)])
        moved = with_obstacles_at(self.problem, obstacles) if obstacles else self.problem
        self.problem = replace(moved, start=start)
        self._asked += 1
        for known in (self._moved, self._moved_meanwhile, self._moved_while_shortening):
            known.update(obstacles or ())
        self._idle.clear()
        try:
            with old_objects_left_alone():
                answer = self._answered(elapsed, begun + self.deadline)
        finally:
            self._idle.set()
        off = _apart(self.problem, answer.trajectory)
        self.last = replace(answer, seconds=time.monotonic() - begun, off=off)
        return self.last

    def _answered(self, elapsed: float, end: float) -> Replan:
        self.stop = self._stop_from(elapsed, end)
        for answer in self._candidates(elapsed, end):
            way, stop = self._ready
            if answer.trajectory is not way or stop is None:
                stop = self._stopping(answer, end)
            if stop is not None:
                self._follow(answer, stop)
                self._moved.clear()
                return answer
        return self.stop

    def _follow(self, answer: Replan, stop: Replan) -> None:
        self._way, self.stop, self._searches = answer.trajectory, stop, 0
        self._give_up()
        if answer.by == "searched" and self._asked:  # the first answer is as short as it is to be
            self._shorten()

    def _give_up(self) -> None:
        """Let a search end by itself, from where the machine does not come to rest any more.

        It may be verifying what it found: to wait for that would take longer than a deadline.
        """
        if self._search is not None:
            self._search.closed = True
        self._search = None

    def _stop_from(self, elapsed: float, end: float) -> Replan:
        """Return what is left of the stop; where something has moved into it, another one."""
        known = self.stop
        left = later(self.problem, known.trajectory, elapsed)
        if left is None:  # it is over, and the machine stands
            last = len(known.trajectory.u)
            left = known.trajectory.piece(last, last)
            task = replace(known.problem, start=left.x[0])
            return replace(known, by="stop", problem=task, trajectory=left)
        if not self._still_free(left, self._moved):
            brake = self._brake(self.problem, left, end)
            if brake is not None:
                self._give_up()
                return Replan("stop", replace(self.problem, goal=_rest(self.problem)), *brake)
        task, proofs = replace(known.problem, start=left.x[0]), _moved(known.proofs, -elapsed)
        return replace(known, by="stop", problem=task, trajectory=left, proofs=proofs)

    def _candidates(self, elapsed: float, end: float) -> Iterator[Replan]:
        """Yield verified motions into the goal, the cheapest to find first."""
        way = later(self.problem, self.last.trajectory, elapsed)
        if way is None:
            yield from self._arrived()
        if self.last.by != "stop":
            if (found := self._shortened(way)) is not None:
                yield from self._along(*found, end, "shortened")
            yield from self._along(way, (), end)
        elif (found := self._found(0.0)) is not None:
            yield from self._along(*found, end, "searched")
            self._give_up()  # what was found is of no use any more
        else:
            yield from self._along(self._nearest(), (), end)
        # as much time again is for the proof that the machine can stop from it
        if (found := self._found(0.5 * (end - time.monotonic()))) is not None:
            yield from self._along(*found, end, "searched")

    def _arrived(self) -> Iterator[Replan]:
        """Yield that nothing is left to do, where the machine is in the goal."""
        task, last = self.problem, len(self.last.trajectory.u)
        end = self.last.trajectory.piece(last, last)
        if task.goal_excess(task.start) <= 1.0 and not _touching(task, end):
            yield Replan("kept", replace(task, start=end.x[0]), end)

    def _nearest(self) -> Trajectory:
        """Return the last way into the goal from where it is nearest to the machine."""
        task, way = self.problem, self._way
        apart = np.abs(task.space.difference(task.start, way.x)) / task.scales
        return way.piece(int(apart.max(axis=1).argmin()), len(way.u))

    def _along(
        self, way: Trajectory | None, proofs: tuple[Proof, ...], end: float, by: str = ""
    ) -> Iterator[Replan]:
        """Yield verified motions that leave a way as little as they can.

        Args:
            way: From near the machine into the goal; proved, but for what has moved since.
            proofs: Of what of it no earlier answer has proved.
            end: When they would come too late.
            by: Where that way is from, if it is a new one.
        """
        task = self.problem
        if way is None or not len(way.u):
            return
        moved = {
            "searched": self._moved_meanwhile,
            "shortened": self._moved_while_shortening,
        }.get(by, self._moved)
        broken = _touching(task, way)
        near = _apart(task, way) <= max(self.tolerance, SHORT.end_tolerance)
        if near and not broken and self._still_free(way, moved):
            yield Replan(by or "kept", replace(task, start=way.x[0]), way, proofs)
        for steps in (20, 40, 80):  # steps on each side of what no longer fits, tried in turn
            if time.monotonic() > end:
                return
            mended = _mended(task, way, broken, steps, _half_of_what_is_left(end))
            if mended is not None:
                made, new = mended[0], self._proofs(*mended, end)
                if new is not None and self._still_free(made, moved):
                    kept = _moved(proofs, made.duration - way.duration)
                    yield Replan(by or "mended", task, made, (*new, *kept))
        if time.monotonic() > end:
            return
        whole = trajopt.make_exact(task, way, _half_of_what_is_left(end))
        certificate = None if whole is None else self._verified(task, whole, end)
        if whole is not None and certificate is not None:
            yield Replan(by or "mended", task, whole, (Proof(0.0, whole.duration, certificate),))

    def _found(self, seconds: float) -> tuple[Trajectory, tuple[Proof, ...]] | None:
        """Return a way into the goal, with its proof, if a search is over by then.

        It begins where the stop ends, and is looked for in a thread that goes on between questions.
        """
        search = self._search = self._search or self._searching()
        if not search.wait(max(seconds, 0.0)):
            return None
        if search.result is None:
            self._give_up()
            return None
        way, left = search.result.trajectory, self.stop.trajectory
        last, space = len(left.u), self.problem.space
        joined, stop = left.with_piece(last, last, way, space), search.result.stop
        self._ready = None, None
        if stop is not None:
            whole = left.with_piece(last, last, stop.trajectory, space)
            if self._still_free(whole, self._moved_meanwhile):
                proofs = _moved(stop.proofs, left.duration)
                task = replace(stop.problem, start=left.x[0])
                self._ready = joined, Replan("stop", task, whole, proofs)
        return joined, (Proof(left.duration, joined.duration, search.result.certificate),)

    def _searching(self) -> Coroutine[ProvedMotion | None]:
        """Return a search from where the stop ends."""
        self._searches += 1
        self._moved_meanwhile = set()
        seed, seconds = stream(self.seed, self._asked), SEARCH * 2.0 ** (self._searches - 1)
        left = self.stop.trajectory
        standing = not len(left.u)
        task = replace(self.problem, start=self.problem.start if standing else left.x[-1])

        def work() -> ProvedMotion | None:
            budget = Budget(seconds, improve=0.0, cancelled=lambda: search.closed)
            found = motion(task, self.searcher, seed, budget)
            if found is None or search.closed:
                return None
            certificate = verify(task, found, margin=False)
            if not certificate.passed:
                return None
            proof = Proof(0.0, found.duration, certificate)
            stop = self._stopping(Replan("searched", task, found, (proof,)), math.inf)
            return ProvedMotion(found, certificate, stop)

        search: Coroutine[ProvedMotion | None] = Coroutine(work)
        search.resume()
        return search

    def _shorten(self) -> None:
        """Begin to shorten the way between questions, from where the machine is not soon.

        As much time as that takes is left for its last subproblem and its verification.
        """
        way, self._moved_while_shortening = self._way, set()
        k, last = int(np.searchsorted(way.t, 2.0 * SEARCH)), len(way.u)
        if 2 * k > last:
            self._shorter = None
            return
        rest = way.piece(k, last)
        task, budget = replace(self.problem, start=rest.x[0]), Budget(SEARCH)

        def spent() -> float:
            self._idle.wait()  # whoever asks goes first
            return budget.elapsed / SEARCH

        def work() -> ProvedMotion | None:
            short = trajopt.shorten(task, rest, spent)
            if short.duration > (1.0 - STILL_GAINING) * rest.duration:
                return None
            certificate = verify(task, short, margin=False)
            return ProvedMotion(short, certificate) if certificate.passed else None

        self._shorter = Coroutine(work)
        self._shorter.resume()

    def _shortened(self, way: Trajectory | None) -> tuple[Trajectory, tuple[Proof, ...]] | None:
        """Return the way made shorter further on, with its proof, once that is done."""
        if way is None or self._shorter is None or not self._shorter.wait(0.0):
            return None
        found, self._shorter = self._shorter.result, None
        if found is None:
            return None
        short, last = found.trajectory, len(way.u)
        apart = np.abs(self.problem.space.difference(short.x[0], way.x)) / self.problem.scales
        k = int(apart.max(axis=1).argmin())
        if apart[k].max() > SHORT.end_tolerance:  # it is there already, or goes another way
            self._shorten()
            return None
        joined = way.with_piece(k, last, short, self.problem.space)
        return joined, (Proof(float(way.t[k]), joined.duration, found.certificate),)

    def _proofs(
        self, made: Trajectory, new: Sequence[tuple[int, int]], end: float
    ) -> tuple[Proof, ...] | None:
        """Return the proofs of the parts of a motion that are new, by their knots; None without."""
        proofs = []
        for first, last in new:
            own = _between(self.problem, made, first, last)
            certificate = self._verified(own, made.piece(first, last), end)
            if certificate is None:
                return None
            proofs.append(Proof(float(made.t[first]), float(made.t[last]), certificate))
        return tuple(proofs)

    def _still_free(self, made: Trajectory, moved: Collection[str]) -> bool:
        """Say whether all of a motion is free of what has moved since its parts were proved."""
        task = self.problem
        if not moved:
            return True
        world = task.world
        there = tuple(one for one in world.obstacles if one.name in moved)
        alone = replace(task, world=replace(world, obstacles=there), start=made.x[0])
        return collision_check(alone, made).passed

    def _verified(self, task: PlanningTask, made: Trajectory, end: float) -> Certificate | None:
        """Return the certificate of a motion; None if it fails, or would come too late."""
        begun, knots = time.monotonic(), len(made.t)
        if begun + self._pace * knots > end:
            return None
        certificate = verify(task, made, margin=False)
        self._pace = (time.monotonic() - begun) / knots
        return certificate if certificate.passed else None

    def _stopping(self, answer: Replan, end: float) -> Replan | None:
        """Return what follows an answer until the next one is there, and comes to rest: proved."""
        task, trajectory = answer.problem, answer.trajectory
        k, last = int(np.searchsorted(trajectory.t, self.period)), len(trajectory.u)
        if k >= last:
            return answer  # it has arrived by then
        if task.rests(trajectory.x[k]):
            known = tuple(one for one in answer.proofs if one.begin < trajectory.t[k])
            return Replan("stop", replace(task, goal=_rest(task)), trajectory.piece(0, k), known)
        made = self._brake(replace(task, start=trajectory.x[k]), trajectory.piece(k, last), end)
        if made is None:
            return None
        brake, (proof,) = made
        whole, begin = trajectory.with_piece(k, last, brake, task.space), float(trajectory.t[k])
        proof = replace(proof, begin=begin, end=whole.duration)
        kept = tuple(one for one in answer.proofs if one.begin < begin)
        return Replan("stop", replace(task, goal=_rest(task)), whole, (*kept, proof))

    def _brake(
        self, task: PlanningTask, way: Trajectory, end: float
    ) -> tuple[Trajectory, tuple[Proof]] | None:
        """Return how the machine comes to rest from its start along a way, with its proof."""
        rest = replace(task, goal=_rest(task))
        # steps in which a machine may come to rest, tried in turn: too few take long to be refuted
        for steps in (40, 80, 20):
            if time.monotonic() > end:
                break
            late = _after(end - self._pace * steps)  # it must be verified in time
            brake = trajopt.make_exact(rest, _slowed(task, way, steps), late)
            certificate = None if brake is None else self._verified(rest, brake, end)
            if brake is not None and certificate is not None:
                return brake, (Proof(0.0, brake.duration, certificate),)
        return None


def replanner(
    problem: PlanningTask,
    searcher: AbstractPlanner,
    first: Replan,
    *,
    deadline: float,
    period: float,
    seed: int = 1,
    tolerance: float = OFF,
) -> Replanner:
    """Return what plans again from a first plan on, with everything compiled that it may need."""
    made = Replanner(problem, searcher, first, math.inf, period, seed, tolerance=0.0)
    beside = problem.start + SHORT.end_tolerance * 10.0 * problem.scales
    standing = {one.name for one in problem.world.obstacles}
    known = {one.name: one.position for one in problem.scenario.world.obstacle}
    made.replan(beside, 0.0, {name: known[name] for name in standing & set(known)})
    return Replanner(problem, searcher, first, deadline, period, seed, tolerance, _pace=made._pace)


def later(task: PlanningTask, known: Trajectory, elapsed: float) -> Trajectory | None:
    """Return a motion from a moment in [s] on, with times from 0; None where it is over.

    Where that is between two knots, it is integrated how far the machine has come by then: what is
    interpolated would be no motion of it.
    """
    k = int(np.searchsorted(known.t, elapsed + SHORT.even_step_tolerance, side="right")) - 1
    if k >= len(known.u):
        return None
    t, x = known.t[k:] - elapsed, known.x[k:].copy()
    if t[0] < 0.0:
        inputs = known.inputs[k : k + 1]
        x[0] = reference_motion(task, x[0], np.array([t[0], 0.0]), inputs, between=False).x[-1]
    t[0] = 0.0
    return replace(known, t=t, x=x, u=known.u[k:], references=known.references[k:])


def _moved(proofs: Sequence[Proof], by: float) -> tuple[Proof, ...]:
    """Return proofs of what comes so much later, in [s]; what is over has none."""
    moved = (replace(one, begin=max(one.begin + by, 0.0), end=one.end + by) for one in proofs)
    return tuple(one for one in moved if one.end > 0.0)


def _half_of_what_is_left(end: float) -> CancellationToken:
    """Return what gives up while there is as much time again for something else."""
    return _after(0.5 * (time.monotonic() + end))


def _after(late: float) -> CancellationToken:
    return lambda: time.monotonic() > late


def _apart(task: PlanningTask, rest: Trajectory) -> float:
    """Return how far the machine is from where a motion begins, of an entry's scale at most."""
    apart = task.space.difference(task.start, rest.x[0]) / task.scales
    return float(np.abs(apart).max())


def _touching(task: PlanningTask, rest: Trajectory) -> list[tuple[int, int]]:
    """Return first and last knots of what touches something, one range after the other."""
    ends = np.stack([task.model.cables(x) for x in rest.x]) if task.cables else None
    touching = task.checker().clearances(task.model.frames(rest.x), ends, 0.1) <= 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touching.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _between(task: PlanningTask, made: Trajectory, begin: int, end: int) -> PlanningTask:
    """Return the problem of a part of a motion: to its last state, or into the goal."""
    start = task.start if begin == 0 else made.x[begin]
    if end == len(made.u):
        return replace(task, start=start)
    return segment_problem(task, start, made.x[end])


def _mended(
    task: PlanningTask,
    rest: Trajectory,
    broken: Sequence[tuple[int, int]],
    steps: int,
    late: CancellationToken,
) -> tuple[Trajectory, list[tuple[int, int]]] | None:
    """Leave a motion only around what no longer fits.

    Returns:
        The motion, and the knots between which it is new; None if that fails.
    """
    made, last = rest, len(rest.u)
    new: list[tuple[int, int]] = []
    ranges = [(0, min(steps, last))]  # the state is never quite what was planned
    ranges += [(max(a - steps, 0), min(b + steps, last)) for a, b in broken]
    for begin, end in reversed(_joined(ranges)):
        own = _between(task, rest, begin, end)
        # subproblems of a mended part; those that succeed take two to five
        piece = trajopt.make_exact(own, rest.piece(begin, end), late, 12)
        if piece is None:
            return None
        made = made.with_piece(begin, end, piece, task.space)
        longer = len(piece.u) - (end - begin)
        new = [(begin, begin + len(piece.u)), *((a + longer, b + longer) for a, b in new)]
    return made, new


def _joined(ranges: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return ranges of knots in order, those that overlap as one."""
    joined: list[tuple[int, int]] = []
    for begin, end in sorted(ranges):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined


def _slowed(task: PlanningTask, way: Trajectory, steps: int) -> Trajectory:
    """Return a guess that goes on along a motion's path and loses its speed evenly."""
    t: Array = task.step * np.arange(steps + 1.0)
    left = 1.0 - t / t[-1]  # of the speed
    now = way.at(np.minimum(t - 0.5 * t**2 / t[-1], way.duration))
    x = now.x.copy()
    x[:, task.model.nq :] *= left[:, None]
    return replace(way, t=t, x=x, u=now.u[:-1], references=now.references[:-1])


def _rest(task: PlanningTask) -> Goal:
    """Return the goal of a machine that stands, wherever."""
    rates = list(range(task.model.nq, task.model.nx))
    near = SHORT.end_tolerance * task.scales[rates]
    return Goal(tuple(rates), np.zeros(len(rates)), near, task.circular[rates])
