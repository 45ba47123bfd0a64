"""Cancellation tokens: asked now and then, at once or seldom."""

from __future__ import annotations

import pytest

from kinolab.concurrency.cancel import (
    CancelledError,
    never_cancelled,
    raise_if_cancelled,
    throttled,
)


def test_looking_raises_only_when_it_is_time() -> None:
    raise_if_cancelled(never_cancelled)
    with pytest.raises(CancelledError):
        raise_if_cancelled(lambda: True)


@pytest.mark.parametrize("times", [1, 3, 5])
def test_a_throttled_token_asks_every_so_often_and_never_again_once_it_is_cancelled(
    times: int,
) -> None:
    asked = 0

    def cancelled() -> bool:
        nonlocal asked
        asked += 1
        return asked == 3

    token = throttled(cancelled, times)
    answers = [token() for _ in range(4 * times)]
    assert answers == [False] * (2 * times) + [True] * (2 * times)
    assert asked == 3
