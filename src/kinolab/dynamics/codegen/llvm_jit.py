"""Machine code from LLVM IR text, by the LLVM that numba brings."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any
from weakref import WeakValueDictionary

import llvmlite.binding as llvm


@dataclass(frozen=True)
class Library:
    """Compiled functions; their addresses stay valid while this object lives."""

    tracker: Any

    def address(self, function: str) -> int:
        """Return the address of a function, to be called through the C interface."""
        return int(self.tracker[function])


# By code and functions: machines that differ in values of parameters have the same.
_linked: WeakValueDictionary[tuple[bytes, frozenset[str]], Library] = WeakValueDictionary()


def compile_ir(text: str, *, quick: bool = False) -> bytes:
    """Compile a module of LLVM IR, optimised for this processor, to an object file's bytes.

    Args:
        quick: Whether numbers stay in memory rather than in registers: for long functions, whose
            registers take a time to allocate that grows with the square of their length.
    """
    _initialise()
    module = llvm.parse_assembly(text)
    module.verify()
    machine = _target_machine(0 if quick else 1)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def link(code: bytes, functions: Iterable[str]) -> Library:
    """Load an object file into this process, once while it is in use.

    LLVM forgets all of it, its names too, only with the linker; so each library has its own.

    Args:
        code: Bytes of an object file of ``compile_ir``, from this kind of processor.
        functions: Names of the functions that will be asked for.
    """
    names = frozenset(functions)
    key = hashlib.sha256(code).digest(), names
    library = _linked.get(key)
    if library is None:
        _initialise()
        builder = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
        for function in names:
            builder = builder.export_symbol(function)
        linker = llvm.create_lljit_compiler(_target_machine())
        library = _linked[key] = Library(builder.link(linker, "kinolab"))
    return library


def processor() -> str:
    """Return what code is compiled for: triple, processor, its features and LLVM's version."""
    version = ".".join(map(str, llvm.llvm_version_info))
    features = llvm.get_host_cpu_features().flatten()
    return f"{llvm.get_default_triple()} {llvm.get_host_cpu_name()} {features} {version}"


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _target_machine(level: int = 1) -> Any:
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=level,  # 2 takes a fifth longer than 1 for code as long and as quick
        reloc="pic",
    )
