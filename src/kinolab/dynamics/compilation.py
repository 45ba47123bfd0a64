"""Machine code from LLVM IR text, by the LLVM that numba brings."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite.binding as llvm


@dataclass(frozen=True)
class Library:
    """Compiled functions; their addresses stay valid while this object lives."""

    engine: Any

    def address(self, function: str) -> int:
        """Return the address of a function, to be called through the C interface."""
        return int(self.engine.get_function_address(function))


def compile_ir(text: str) -> Library:
    """Compile a module of LLVM IR, optimised for this processor."""
    _initialise()
    module = llvm.parse_assembly(text)
    module.verify()
    machine = _target_machine()
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return Library(engine)


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _target_machine() -> Any:
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=2,
    )
