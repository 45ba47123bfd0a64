"""One engine for all machines of a process."""

from collections.abc import Iterator

import pytest

from tests.javascript_engine import Engine


@pytest.fixture(scope="session")
def engine() -> Iterator[Engine]:
    with Engine() as made:
        yield made
