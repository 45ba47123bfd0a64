"""Machine code from LLVM IR text, by the LLVM that numba brings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any

import llvmlite.binding as llvm

_names = count()


@dataclass(frozen=True)
class Library:
    """Compiled functions; their addresses stay valid while this object lives."""

    tracker: Any

    def address(self, function: str) -> int:
        """Return the address of a function, to be called through the C interface."""
        return int(self.tracker[function])


def compile_ir(text: str) -> bytes:
    """Compile a module of LLVM IR, optimised for this processor, to an object file's bytes."""
    _initialise()
    module = llvm.parse_assembly(text)
    module.verify()
    machine = _target_machine()
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def link(code: bytes, functions: Iterable[str]) -> Library:
    """Load an object file into this process.

    Args:
        code: Bytes of an object file of ``compile_ir``, from this kind of processor.
        functions: Names of the functions that will be asked for.
    """
    _initialise()
    builder = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
    for function in functions:
        builder = builder.export_symbol(function)
    return Library(builder.link(_linker(), f"kinolab {next(_names)}"))


def processor() -> str:
    """Return what code is compiled for: triple, processor, its features and LLVM's version."""
    version = ".".join(map(str, llvm.llvm_version_info))
    features = llvm.get_host_cpu_features().flatten()
    return f"{llvm.get_default_triple()} {llvm.get_host_cpu_name()} {features} {version}"


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@cache
def _linker() -> Any:
    return llvm.create_lljit_compiler(_target_machine())


def _target_machine() -> Any:
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=1,  # 2 takes a fifth longer for code as long and as quick
        reloc="pic",
    )
