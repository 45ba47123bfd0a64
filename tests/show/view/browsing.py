"""A browser for pages, without a graphics processor, as on a server."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--no-first-run", "--disable-quic"),
)
OWN = ("file:", "data:", "blob:")
WIDE = {"width": 1000, "height": 640}

Opener = Callable[..., Any]

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on this machine")


def until(page: Any, condition: str, patience: float = 20.0) -> None:
    """Wait for a condition; the page forbids what Playwright's own waiting would evaluate in it."""
    end = time.monotonic() + patience
    while not page.evaluate(condition):
        if time.monotonic() > end:
            pytest.fail(f"it never came to {condition}")
        page.wait_for_timeout(10)


def inner_frames(page: Any) -> list[Any]:
    """The frames of a page, once the pages in them run: until then a frame holds an empty one."""
    frames = [frame for frame in page.frames if frame != page.main_frame]
    for frame in frames:
        until(frame, "Boolean(window.kinolab?.ready)")
    return frames
