"""Options of trajectory optimisation: thresholds, weights, tolerances and iteration limits.

Unless a unit is given, violations and tolerances are scaled, clearances are in machine sizes and
durations are fractions. Constants of compiled kernels stay in the kernels' own files, whose changes
trigger recompilation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from kinolab.settings import setting


@final
@dataclass(frozen=True, kw_only=True)
class NlpOptions:
    """Options of the nonlinear program and of the feasibility check."""

    step_tolerance: float = setting(1e-9, meaning="Error of one step of the map.")
    max_substeps: int = setting(64, meaning="Substeps of a step at most.")
    derivative_tolerance: float = setting(1e-4, meaning="Error of derivatives: none of a motion.")
    sampled_step_stride: int = setting(4, meaning="Steps of which one shows that error.")
    curvature_step: float = setting(1e-4, meaning="Finite difference of a cost, of a scale.")
    check_resolution: float = setting(0.12, meaning="Motion between two samples, about.")
    max_samples_per_step: int = setting(8, meaning="Samples of a step at most.")
    check_factor: int = setting(4, meaning="Times as many samples where a motion is judged.")
    limit_fraction: float = setting(0.05, meaning="Reserve of limits, of that of gaps.")
    room: float = setting(0.6, meaning="Room that planners ask for, of their check's resolution.")
    excess_factor: float = setting(1.2, meaning="Of what passes a limit between knots: reserve.")
    amplified_tolerance: float = setting(1e-6, meaning="Reserve of limits of discrete motions.")
    duration_digits: int = setting(9, meaning="Digits in which equal steps agree.", unit="s")
    transition_lag: float = setting(
        1e-2, meaning="Of a step: how long after its beginning a transition takes place."
    )
    fd_step: float = setting(1e-6, meaning="Finite difference of a state's entry, in its unit.")
    scaled_fd_step: float = setting(1e-6, meaning="Finite difference in scales, for margins.")
    random_states: int = setting(8, meaning="States that show which margins inputs decide.")


@final
@dataclass(frozen=True, kw_only=True)
class SqpOptions:
    """Options of the SQP solver: trust region, merit function, subproblems, restoration."""

    accept_ratio: float = setting(0.1, meaning="Actual of predicted reduction to take a step.")
    expand_ratio: float = setting(0.7, meaning="The same to let the trust region grow.")
    min_radius: float = setting(1e-7, meaning="Trust region that ends a sequence.")
    max_radius: float = setting(4.0, meaning="Trust region at most.")
    min_good_radius: float = setting(0.02, meaning="Trust region at first and after good steps.")
    max_first_radius: float = setting(1.0, meaning="Trust region at first, at most.")
    radius_per_violation: float = setting(10.0, meaning="First trust region over the violation.")
    time_radius: float = setting(0.5, meaning="First trust region where time is minimised.")
    min_predicted: float = setting(1e-4, meaning="Predicted reduction, of the cost, to go on.")
    retry_ratio: float = setting(0.3, meaning="Violation, of the last, for a least-norm step.")
    pace_iterations: int = setting(3, meaning="Subproblems after which the pace is checked.")
    min_decrease: float = setting(0.05, meaning="Decrease of a far guess's violation in these.")
    exact_violation: float = setting(1e-11, meaning="Violation that counts as nothing.")
    nearly_exact_violation: float = setting(1e-8, meaning="Violation that each step must halve.")
    rounding_violation: float = setting(100 * 1e-11, meaning="Violation that rounding may leave.")
    closure_tolerance: float = setting(1e-8, meaning="Violation on the way to a restoration.")
    closure_iterations: int = setting(8, meaning="Subproblems that close what a step opened.")
    max_contraction: float = setting(0.7, meaning="Part of the violation that one may leave.")
    violation_penalty: float = setting(10.0, meaning="Merit of a violation; costs are about 1.")
    bold_penalty: float = setting(100.0, meaning="The same for guesses that must change a lot.")
    step_accuracy: float = setting(1e-6, meaning="Accuracy of a step that is closed afterwards.")
    optimality_tolerance: float = setting(1e-8, meaning="Duality gap of a program, of its merit.")
    regularisation: float = setting(1e-8, meaning="Least one; less gives up on many optima.")
    step_damping: float = setting(1e-8, meaning="Weight of squared changes: strict convexity.")
    no_defect: float = setting(1e-9, meaning="Sum of defects below which none is left open.")
    max_active_sets: int = setting(12, meaning="Active sets of a least-norm step at most.")
    releasing_active_sets: int = setting(6, meaning="The first of them, which may let go.")
    bound_tolerance: float = setting(1e-12, meaning="How far variables may pass their limits.")
    inequality_tolerance: float = setting(1e-11, meaning="How far inequalities may.")
    step_length_weight: float = setting(1e-6, meaning="Weight of the step length, of a state's.")
    coarse_violation: float = setting(1.0, meaning="Violation from which coarse knots come first.")
    coarsening_factors: tuple[int, ...] = setting((4, 3, 2), meaning="Steps between coarse knots.")
    min_coarse_steps: int = setting(50, meaning="Coarse steps at least.")
    coarse_iterations: int = setting(30, meaning="Subproblems for coarse knots.")


@final
@dataclass(frozen=True, kw_only=True)
class StoppingTolerances:
    """Stopping criteria of the time minimisation; the loose ones are for segments."""

    min_radius: float = setting(1e-3, meaning="Trust region below which nothing is gained.")
    min_predicted: float = setting(1e-3, meaning="Predicted gain, of the cost, to go on.")
    min_gain: float = setting(0.0, meaning="Actual gain, of the cost, to go on.")


@final
@dataclass(frozen=True, kw_only=True)
class ShorteningOptions:
    """Options of making trajectories exact, segmenting and shortening them."""

    exact_clearances: tuple[float, ...] = setting((1e-2, 5e-2, 2e-3), meaning="Reserves of gaps.")
    short_clearances: tuple[float, ...] = setting((7e-2, 2e-2, 4e-2, 2e-3), meaning="Likewise.")
    min_reserve_gain: float = setting(0.05, meaning="Gain for which a gap may be smaller.")
    coarse_clearance: float = setting(2e-2, meaning="The same for coarse knots.")
    segment_clearances: tuple[float, float] = setting(
        (4e-2, 5e-3), meaning="The same for segments."
    )
    segment_limit_fraction: float = setting(0.5, meaning="Reserve of limits, of that of gaps.")
    near_gaps: float = setting(0.15, meaning="Gaps that matter, of half the largest shape.")
    even_step_tolerance: float = setting(1e-9, unit="s", meaning="Difference of even steps.")
    long_steps: int = setting(150, meaning="Steps of a long motion, which is cut into segments.")
    min_steps: int = setting(8, meaning="Steps that leave inputs enough freedom.")
    defect_tolerance: float = setting(1e-6, meaning="Defect of a true motion.")
    centre_tolerance: float = setting(1e-6, meaning="Violation of the goal at its centre.")
    tail_steps: tuple[int, ...] = setting((50, 100, 200, 400), meaning="Last steps.")
    tail_knots: int = setting(40, meaning="Knots of these at most.")
    end_tolerance: float = setting(1e-6, meaning="How far from its end a segment may end.")
    min_round_gain: float = setting(1e-3, meaning="Gain of a round to go on.")
    min_sweep_gain: float = setting(0.03, meaning="Gain of a sweep over segments to go on.")
    min_segment_gain: float = setting(0.03, meaning="Gain for which a segment is replaced.")
    small_gain: float = setting(0.05, meaning="Gain of a shortcut after which cycles are tried.")
    min_duration: float = setting(0.1, meaning="Duration of a faster motion at least.")
    min_segment_duration: float = setting(0.05, meaning="Duration of a faster segment at least.")
    stretch: tuple[float, float] = setting((0.4, 2.0), meaning="Durations near a guess.")
    eased: tuple[float, float] = setting(
        (0.9, 1.1), meaning="The same where inputs are held for longer."
    )
    far_iterations: int = setting(25, meaning="Subproblems for a guess that is no motion yet.")
    coarse_knots: int = setting(50, meaning="Coarse knots of the first faster motion, about.")
    segment_budget: float = setting(0.9, meaning="Budget for segments.")
    inexact_segment_budget: float = setting(0.85, meaning="Where the goal is not met yet.")
    whole_budgets: tuple[float, float] = setting(
        (0.5, 0.8), meaning="Of what is left: for coarse knots, and the first reserve of gaps."
    )
    segment_subproblems: int = setting(5, meaning="Subproblems of segments that count as one.")
    step_reduction: float = setting(0.7, meaning="Shortest step before there are fewer of them.")
    max_rounds: int = setting(20, meaning="Rounds with fewer and fewer steps at most.")
    max_step_counts: int = setting(4, meaning="Numbers of steps that are tried at most.")
    window_knots: tuple[int, int] = setting((20, 40), meaning="Knots of a window: first, later.")
    steps_per_knot: float = setting(16.0, meaning="Steps between its knots at first.")
    min_steps_per_knot: float = setting(2.0, meaning="The same, at least.")
    max_steps_per_knot: float = setting(32.0, meaning="The same, at most.")
    window_growth: float = setting(1.3, meaning="Next window's length after one that worked.")
    window_shrinkage: float = setting(0.5, meaning="The same after one that did not.")
    min_remainder: float = setting(1 / 3, meaning="Part of a window that is one at the end.")
    shortcut_samples: tuple[int, ...] = setting((24, 31, 27), meaning="Samples of a motion.")
    max_slow_shortcuts: int = setting(20, meaning="Slow guesses of shortcuts before it ends.")
    max_failed_shortcuts: int = setting(5, meaning="Failed shortcuts before it ends.")
    promised_duration: float = setting(0.7, meaning="Least time of a shortcut worth a try.")
    shortcut_knots: int = setting(20, meaning="Knots of a shortcut at most.")
    curve_samples: tuple[int, ...] = setting((12, 60), meaning="Samples of a curve: first, later.")
    shortcut_duration: float = setting(1.5, meaning="Duration of a straight guess, of the least.")
    phase_steps: int = setting(6, meaning="Steps of a phase between two transitions.")
    phase_budgets: tuple[float, float] = setting(
        (0.35, 0.75), meaning="Budget for guesses of fewer phases; until the last is checked."
    )
    phase_samples: int = setting(2, meaning="Samples of such a step, until a motion is checked.")
    phase_pace: float = setting(0.3, meaning="Decrease of violation in a few subproblems.")
    max_failed_phases: int = setting(4, meaning="Cycles of modes that are tried to be left out.")
    max_slower_phases: int = setting(2, meaning="Numbers of phases that are no shorter, in turn.")
    max_tightenings: int = setting(3, meaning="Times that limits of phases are tightened.")
    coarse_phase_violation: float = setting(
        1e-2, meaning="Violation of phases that become feasible."
    )
    cycle_samples: int = setting(300, meaning="Samples that are compared at most.")
    min_cycle_spacing: int = setting(5, meaning="Steps between two of them at least.")
    blend_steps: int = setting(50, meaning="Steps on each side over which a gap is spread.")
    min_cycle_steps: int = setting(20, meaning="Steps of a cycle at least.")
    max_cycle_gap: float = setting(0.16, meaning="Gap between its ends at most, of its length.")
    negligible_gap: float = setting(0.1, meaning="Gap that is none, of what those steps take.")
    gap_exponent: float = setting(1.5, meaning="Power of a gap that counts against its duration.")
    same_cycle_samples: int = setting(4, meaning="Samples between the ends of alike cycles.")
    cycle_knots: int = setting(40, meaning="Knots of a guess without a cycle at most.")
    max_failed_cycles: int = setting(8, meaning="Failed cycles before it ends.")


@final
@dataclass(frozen=True, kw_only=True)
class GuessOptions:
    """Options of multistart: initial guesses through free configurations."""

    clearance: float = setting(1e-2, meaning="Reserve of gaps.")
    few_knots_tolerance: float = setting(1e-6, meaning="Violation from which knots become many.")
    fine_iterations: int = setting(12, meaning="Subproblems with many knots.")
    max_iterations: tuple[int, int] = setting((20, 30), meaning="Subproblems: first, later.")
    arcs: int = setting(16, meaning="Of constant extreme inputs, in a word of them.")
    words: int = setting(16, meaning="Of which the shortest is taken.")
    word_iterations: int = setting(40, meaning="To make a word short.")
    reversed_samples: int = setting(20, meaning="States that show whether motions run backward.")
    tree_iterations: int = setting(20_000, meaning="Of each of the smallest two trees.")
    tree_slice: int = setting(1000, meaning="Iterations between looks at the clock.")
    tree_steps: tuple[int, int] = setting((1, 20), meaning="Range of steps of an input in trees.")
    tree_goal_bias: float = setting(0.05, meaning="Probability of growth toward the other tree.")
    tree_goal_scale: float = setting(10.0, meaning="What is near the goal, in tolerances.")
    pairs: int = setting(6, meaning="Of nodes of two trees, of which guesses are made.")
    pair_slack: float = setting(0.1, meaning="Fraction by which a gap may exceed the least one.")
    min_repeatable: float = setting(0.25, meaning="Duration at least, where errors grow.")
    durations: tuple[float, ...] = setting((2.0, 3.0, 1.4, 4.0, 2.5, 6.0), meaning="In turn.")
    kinematic_guesses: int = setting(8, meaning="Of the reduction, until one becomes a motion.")
    slower_than_kinematic: tuple[float, float] = setting(
        (1.1, 1.6), meaning="Durations of kinematic motions with the dynamics, in turn."
    )
    duration_jitter: float = setting(0.2, meaning="How far its logarithm is off at random.")
    turning: tuple[float, ...] = setting((0.1, 0.3, 1.0), meaning="Random half turns of paths.")
    odds: tuple[float, ...] = setting((0.4, 0.1, 0.25, 0.25), meaning="And of a detour.")
    roadmap_states: int = setting(500, meaning="Free configurations of a roadmap.")
    roadmap_poses: int = setting(200, meaning="The same, of a roadmap of curves.")
    roadmap_draws: int = setting(64, meaning="Of which so many are drawn at a time.")
    tight_samples: int = setting(60, meaning="Of a motion whose path is pulled tight.")
    tight_rounds: int = setting(3, meaning="Of shortcuts that do that.")
    max_branches: tuple[int, int] = setting((600, 2500), meaning="Of trees, and for short paths.")
    shorter: tuple[float, float] = setting((0.4, 1.0), meaning="Range of a path's duration.")
    min_guess_steps: int = setting(10, meaning="Steps of a guess at least.")
    max_guess_steps: int = setting(20_000, meaning="The same, at most: others are left alone.")
    max_aims: int = setting(40, meaning="States in the goal that are drawn to find free ones.")
    compared_aims: int = setting(4, meaning="Free states in the goal, of which the nearest counts.")
    max_draws: int = setting(50, meaning="Draws of a configuration on a path that is short.")
    max_path_shortcuts: int = setting(60, meaning="Shortcuts of a path that are tried.")
    path_resolution: float = setting(0.25, meaning="Motion between samples, of the least radius.")
    min_path_samples: int = setting(4, meaning="Samples of a straight path at least.")
    max_path_samples: int = setting(4096, meaning="The same, at most.")
    first_check_stride: int = setting(8, meaning="Samples of which one is checked first.")
    speed_samples: int = setting(200, meaning="States and inputs that show largest rates.")
    max_detour: float = setting(0.25, meaning="Random detour, of a coordinate's range.")
    unlimited: float = setting(100.0, unit="s", meaning="Speeding up that tells of no limit.")
    perturbation: float = setting(0.01, meaning="Noise of the inputs, of their range.")
    headings: int = setting(360, meaning="Angles tried as the heading of a path's leg.")
    attitudes: int = setting(24, meaning="The same of bodies that turn anyhow.")
    sideways: float = setting(0.1, meaning="Forbidden share of a leg that is turned.")
    slip: float = setting(0.02, meaning="The same that a heading may leave.")
    rank_tolerance: float = setting(1e-6, meaning="Singular values that are none, of the largest.")


@final
@dataclass(frozen=True, kw_only=True)
class TimingOptions:
    """Options of the time scaling of paths, from rest to rest."""

    ramps: tuple[float, ...] = setting((0.5, 0.3, 0.15), meaning="Shares that speed up, tried.")
    used: float = setting(0.9, meaning="Fraction of limits that a motion uses.")
    durations: tuple[float, float] = setting((0.02, 1e3), unit="s", meaning="Of a leg.")
    bisections: int = setting(18, meaning="Of that range, for the shortest duration.")
    limit_samples: int = setting(41, meaning="Samples at which limits are checked.")
    samples_per_step: int = setting(4, meaning="Samples over which held inputs are averaged.")


@final
@dataclass(frozen=True, kw_only=True)
class EndOptions:
    """Options of single shooting into the goal's centre, of machines with many states."""

    many_states: int = setting(40, meaning="From so many on, nothing else is optimised.")
    tail_steps: tuple[int, ...] = setting((100, 200), meaning="Last steps that change, in turn.")
    blocks: int = setting(4, meaning="Of steps in which inputs change alike.")
    newton_steps: int = setting(8, meaning="Gauss-Newton steps at most.")
    least_share: float = setting(0.1, meaning="Of such a step, at which it is given up.")
    fd_step: float = setting(1e-3, meaning="Finite difference of an input, of half its range.")
    ridge: float = setting(1e-4, meaning="What a change costs, of the derivatives' norm.")
    goal_tolerance: float = setting(1e-7, meaning="Goal residual that counts as none.")
    cost_of_state: float = setting(6e-6, unit="s", meaning="Work per step and state.")


TIMING = TimingOptions()
END = EndOptions()
NLP, SQP, SHORT, GUESS = NlpOptions(), SqpOptions(), ShorteningOptions(), GuessOptions()
TIGHT = StoppingTolerances()
LOOSE = StoppingTolerances(min_radius=0.03, min_predicted=0.02, min_gain=0.03)
OPTIONS = {
    "nlp": NLP,
    "sqp": SQP,
    "shorten": SHORT,
    "guess": GUESS,
    "timing": TIMING,
    "end": END,
    "tight": TIGHT,
    "loose": LOOSE,
}
