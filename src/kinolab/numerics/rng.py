"""Random numbers for compiled code, with one generator per search, so that seeds reproduce.

Source: Blackman, Vigna, Scrambled linear pseudorandom number generators, ACM Transactions on
Mathematical Software 47(4), 2021 (xoroshiro128+).
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.jit import kernel

State: TypeAlias = NDArray[np.uint64]


def generator(seed: int) -> State:
    """Return the state (2,) of a generator for a seed of 0 or more."""
    return np.random.SeedSequence(seed).generate_state(2, np.uint64).astype(np.uint64)


@kernel
def turned(value, by):  # type: ignore[no-untyped-def]
    """Rotate the bits of a number to the left."""
    return (value << np.uint64(by)) | (value >> np.uint64(64 - by))


@kernel
def uniform(state):  # type: ignore[no-untyped-def]
    """Draw a number from [0, 1) and advance the state."""
    one, other = state[0], state[1]
    drawn = one + other
    other ^= one
    state[0] = turned(one, 24) ^ other ^ (other << np.uint64(16))
    state[1] = turned(other, 37)
    return (drawn >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@kernel
def below(state, count):  # type: ignore[no-untyped-def]
    """Draw an integer from [0, count)."""
    return min(int(uniform(state) * count), count - 1)


@kernel
def unit_vector(state, out):  # type: ignore[no-untyped-def]
    """Draw a unit vector uniformly from the sphere: of 4 entries a quaternion, or of 3.

    Source: Shoemake, Uniform random rotations, Graphics Gems III, 1992; Archimedes, On the Sphere
    and Cylinder (a zone's area is proportional to its height).
    """
    if out.shape[0] == 3:
        z, turn = 2 * uniform(state) - 1, 2 * math.pi * uniform(state)
        around = math.sqrt(1 - z * z)
        out[0], out[1], out[2] = around * math.cos(turn), around * math.sin(turn), z
        return
    fraction, a, b = uniform(state), 2 * math.pi * uniform(state), 2 * math.pi * uniform(state)
    less, more = math.sqrt(1.0 - fraction), math.sqrt(fraction)
    out[0], out[1] = less * math.sin(a), less * math.cos(a)
    out[2], out[3] = more * math.sin(b), more * math.cos(b)
