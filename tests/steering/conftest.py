"""Scenes that several tests steer in, each loaded once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from kinolab.problem import PlanningTask
from tests.scenes import scene

Scenes = Callable[..., PlanningTask]


@pytest.fixture(scope="session")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Scenes:
    @cache
    def load(name: str, *overrides: str, text: str = "") -> PlanningTask:
        return scene(tmp_path_factory.mktemp(name), name, *overrides, text=text)

    return load
