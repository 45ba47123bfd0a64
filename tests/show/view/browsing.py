"""A browser for pages, without a graphics processor, as on a server."""

from __future__ import annotations

import shutil
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
