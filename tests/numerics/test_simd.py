"""Lanes against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.simd import (
    FAR,
    LANES,
    bits_of,
    first_lane,
    lanes_at,
    lanes_below,
    lanes_up_to,
    least,
    load,
    maximum,
    minimum,
    next_key,
    ranked,
    spread,
    store,
)

RANDOM = np.random.default_rng(0)
NUMBERS = RANDOM.uniform(0, 1, (3, LANES)).astype(np.float32)


@kernel
def compute(a: Any, row: Any, out: Any) -> None:
    one, other = load(a, (row, 0)), load(a, (row + 1, 0))
    total = one * other
    total += one - other
    store(out, (0, 0), total)
    store(out, (1, 0), minimum(one, other))
    store(out, (2, 0), maximum(one, spread(np.float32(0.5))))


@kernel
def compare(a: Any, row: Any, number: Any) -> Any:
    numbers = load(a, (row, 0))
    at = lanes_at(numbers, least(numbers))
    return lanes_below(numbers, number), lanes_up_to(numbers, number), first_lane(at)


@kernel
def sort(a: Any, lanes: Any, limit: Any) -> Any:
    keys, key, count = ranked(load(a, (0, 0))), -1, 0
    while True:
        key = next_key(keys, key)
        if key & -LANES >= bits_of(limit):
            return count
        lanes[count] = key & (LANES - 1)
        count += 1


def test_arithmetic_is_that_of_single_precision() -> None:
    out = np.zeros((3, LANES), np.float32)
    compute(NUMBERS, 1, out)
    one, other = NUMBERS[1:]
    np.testing.assert_array_equal(out[0], one * other + (one - other))
    np.testing.assert_array_equal(out[1], np.minimum(one, other))
    np.testing.assert_array_equal(out[2], np.maximum(one, np.float32(0.5)))


def test_comparisons_set_the_bits_of_their_lanes() -> None:
    number = NUMBERS[2, 5]
    below, up_to, first = compare(NUMBERS, 2, number)
    bits = 1 << np.arange(LANES)
    assert below == bits[NUMBERS[2] < number].sum()
    assert up_to == bits[NUMBERS[2] <= number].sum() == below + bits[5]
    assert first == NUMBERS[2].argmin()


def test_lanes_are_visited_in_order_and_infinite_ones_never() -> None:
    numbers, lanes = NUMBERS.copy(), np.zeros(LANES, np.int64)
    assert sort(numbers, lanes, FAR) == LANES
    np.testing.assert_array_equal(lanes, numbers[0].argsort())
    numbers[0, 3:9] = FAR
    numbers[0, 10:12] = 0.0  # a tie is visited lane by lane
    assert sort(numbers, lanes, FAR) == LANES - 6
    np.testing.assert_array_equal(lanes[: LANES - 6], numbers[0].argsort(kind="stable")[:-6])
    assert sort(numbers, lanes, np.float32(0.5)) == (numbers[0] < 0.5).sum()
