"""Emitted JavaScript in V8, the engine of Chromium and Node, without a browser."""

from __future__ import annotations

import json
from types import TracebackType
from typing import Any, Self

import pytest

from kinolab.dynamics import Model
from kinolab.dynamics.javascript import javascript_of


class Engine:
    """One engine for many machines; numbers go in and out as JSON, which is exact for float64."""

    def __init__(self) -> None:
        self._context = pytest.importorskip("py_mini_racer").MiniRacer()
        self._places: dict[int, str] = {}
        self._models: list[Model] = []  # kept, so that none of their identities is used again
        self._context.eval("var machines = []")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._context.close()  # its thread would keep the process alive

    def machine(self, model: Model) -> str:
        """Return what JavaScript calls a machine."""
        if id(model) not in self._places:
            self._places[id(model)] = f"machines[{len(self._models)}]"
            self._models.append(model)
            self._context.eval(f"machines.push({javascript_of(model, implicit=True)})")
        return self._places[id(model)]

    def run(self, body: str, *arguments: Any) -> Any:
        """Return the value of a function's body in which the arguments are a, b, c, …"""
        names = ", ".join("abcdefgh"[: len(arguments)])
        given = ", ".join(json.dumps(argument) for argument in arguments)
        answer = self._context.eval(f"JSON.stringify((({names}) => {{ {body} }})({given}) ?? null)")
        return json.loads(answer)
