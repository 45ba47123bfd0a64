"""How far along a piece of a motion nothing is touched, by conservative advancement.

Source: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996.
"""

from __future__ import annotations

from kinolab.numerics.jit import kernel
from kinolab.search.flat.flat_states import inputs_for, state_at
from kinolab.simulation.collision_context import (
    CLEARANCE_HORIZON,
    SAFETY_FACTOR,
    clearance_bound,
    place_machine,
    speed_bound,
)


@kernel
def clearance_at(search, x, reach):  # type: ignore[no-untyped-def]
    """Bound the clearance of a state (nx,) in [m]; ``reach`` is what would suffice."""
    place_machine(search.machine, x, search.scratch)
    need = max(reach, CLEARANCE_HORIZON)
    found = clearance_bound(0.0, need, search.scratch, search.collision)
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

    Between two states nothing is touched if points move by no more than both clearances together.
    The next state is looked at where the same clearance again would just do, and nearer if there is
    less. Within an interval points are taken to be at most SAFETY_FACTOR times as fast as at its
    ends.
    """
    work, T, least = search.work, pieces.duration[k], search.collision.required_clearance
    # of the clearance at one state, of that at the next
    t, speed, hoped = 0.0, speed_at(search, pieces, k, 0.0), 0.75
    here = clearance_at(search, work.x, speed * T)
    if not here >= least:
        return -1.0
    while t < T:
        allowed = (1.0 + hoped) * here
        while True:
            h, then = interval(search, pieces, k, t, speed, allowed)
            search.counts[0] += 1
            there = clearance_at(search, work.x, SAFETY_FACTOR * max(speed, then) * (T - t))
            way = SAFETY_FACTOR * max(speed, then) * h
            if there >= least and way <= here + there:
                break
            if allowed <= here or way <= here:
                return t
            allowed, hoped = here, 0.0  # there is less and less
        t, speed, here = (T if t + h >= T else t + h), then, there
    return T


@kernel
def speed_at(search, pieces, k, t):  # type: ignore[no-untyped-def]
    """Bound the speed of points in [m/s] at a time of a piece; the state is left in ``work.x``."""
    state_at(search, pieces, k, t, search.work.x, search.work.slopes)
    if search.flat.first:
        inputs_for(search, search.work.x, search.work.slopes, search.work.u)
        return speed_bound(search.machine, search.work.x, search.work.u, search.scratch)
    return speed_bound(search.machine, search.work.x, search.limits.still, search.scratch)


@kernel
def interval(search, pieces, k, t, speed, allowed):  # type: ignore[no-untyped-def]
    """Return a time from t in which points move no further than allowed, and their speed after it.

    Args:
        search, pieces, k, t: As ``speed_at`` takes them; ``work.x`` is the state after that time.
        speed: Bound on the speed of points at t, in [m/s].
        allowed: In [m].
    """
    T = pieces.duration[k]
    # intervals that a piece has at least, for speeds that rise and fall within one
    h = min(T - t, T / 4)
    if SAFETY_FACTOR * speed * h > allowed:
        h = allowed / (SAFETY_FACTOR * speed)
    then = speed
    # halvings of an interval: points that move a thousand million times as fast in it
    for _ in range(30):
        then = speed_at(search, pieces, k, t + h)
        if SAFETY_FACTOR * max(speed, then) * h <= allowed:
            break
        h *= 0.5
    return h, then


@kernel
def is_piece_free(search, pieces, k):  # type: ignore[no-untyped-def]
    """Say whether nothing is touched along a piece; three states are looked at first."""
    T = pieces.duration[k]
    for m in (2, 1, 3):
        if not is_state_free(search, pieces, k, 0.25 * m * T):
            return False
    return free_until(search, pieces, k) >= T
