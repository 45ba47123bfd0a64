"""Scenes that several tests steer in, each loaded once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from kinolab.problem import Problem
from tests.scenes import scene

Scenes = Callable[..., Problem]


@pytest.fixture(scope="session")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Scenes:
    @cache
    def load(name: str, *overrides: str, text: str = "") -> Problem:
        return scene(tmp_path_factory.mktemp(name), name, *overrides, text=text)

    return load
