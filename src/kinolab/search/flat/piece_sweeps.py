"""How far along a piece of a motion nothing is touched, by conservative advancement.

Source: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996.
"""

from __future__ import annotations

from kinolab.numerics.jit import kernel
from kinolab.search.flat.flat_states import state_at
from kinolab.simulation.collision_context import (
    CLEARANCE_HORIZON,
    SAFETY_FACTOR,
    clearance_bound,
    place_machine,
    speed_bound,
)

INTERVALS = 4  # that a piece has at least, for speeds that rise and fall within one
HALVINGS = 30  # of an interval: points that move a thousand million times as fast in it


@kernel
def clearance_at(search, x, reach):  # type: ignore[no-untyped-def]
    """Bound the clearance of a state (nx,) in [m]; ``reach`` is what would suffice."""
    place_machine(search.machine, x, search.scratch)
    need = max(reach, CLEARANCE_HORIZON)
    found = clearance_bound(reach, need, search.scratch, search.collision)
    return min(found, search.collision.max_step)


@kernel
def is_state_free(search, pieces, k, t):  # type: ignore[no-untyped-def]
    """Say whether nothing is touched at a time of a piece."""
    state_at(search, pieces, k, t, search.work.x, search.work.slopes)
    least = search.collision.required_clearance
    return clearance_at(search, search.work.x, least) >= least


@kernel
def free_until(search, pieces, k):  # type: ignore[no-untyped-def]
    """Return the time of a piece up to which nothing is touched; negative where not even there.

    Within an interval points are taken to be at most SAFETY_FACTOR times as fast as at its ends.
    """
    work, machine, scratch = search.work, search.machine, search.scratch
    T, still, least = pieces.duration[k], search.limits.still, search.collision.required_clearance
    t, before = 0.0, -1.0
    state_at(search, pieces, k, t, work.x, work.slopes)
    speed = speed_bound(machine, work.x, still, scratch)
    while True:
        search.counts[0] += 1
        clearance = clearance_at(search, work.x, SAFETY_FACTOR * speed * (T - t))
        if not clearance >= least:
            return before
        if t >= T:
            return T
        h = min(T - t, T / INTERVALS)
        if SAFETY_FACTOR * speed * h > clearance:
            h = clearance / (SAFETY_FACTOR * speed)
        then = speed
        for _ in range(HALVINGS):
            state_at(search, pieces, k, t + h, work.x, work.slopes)
            then = speed_bound(machine, work.x, still, scratch)
            if SAFETY_FACTOR * max(speed, then) * h <= clearance:
                break
            h *= 0.5
        before, t, speed = t, (T if t + h >= T else t + h), then


@kernel
def is_piece_free(search, pieces, k):  # type: ignore[no-untyped-def]
    """Say whether nothing is touched along a piece; three states are looked at first."""
    T = pieces.duration[k]
    for m in (2, 1, 3):
        if not is_state_free(search, pieces, k, 0.25 * m * T):
            return False
    return free_until(search, pieces, k) >= T
