"""The one way in which the renderer's pixel loops become machine code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from kinolab.numerics.jit import compiler

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def compiled(kernel: Kernel) -> Kernel:
    """Compile on the first call and keep the result on disk; the kernel releases the GIL."""
    return cast(Kernel, compiler(cache=True, nogil=True)(kernel))
