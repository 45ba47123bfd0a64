"""Compiled functions whose machine code is made only where Python calls them.

numba makes machine code, and a wrapper for Python, of every compiled function, also of those that
only other compiled functions call; their code is in the callers' once more. Here such functions are
kept as LLVM IR that is linked into what calls them. It is optimised there, once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import llvmlite.binding as llvm
from numba import _dynfunc
from numba.core.caching import CompileResultCacheImpl
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering

from kinolab.numerics.jit_cache import SealedCache, cache_of


class _Dispatcher(CPUDispatcher):  # type: ignore[misc]
    """numba's, whose cache is locked while a function is compiled."""

    def compile(self, sig: Any) -> Any:
        """Compile for a signature; if that fails, other processes need not wait any longer."""
        try:
            return super().compile(sig)
        finally:
            if isinstance(self._cache, SealedCache):
                self._cache.release()


class Kernel(_Dispatcher):
    """A compiled function: machine code for Python, IR for other compiled functions.

    Args:
        function: In Python.
        options: As those of ``numba.njit``.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, {}, options)
        self._options, self._known_cache = options, None
        self._compiler._compile_core = self._executable

    @property
    def _cache(self) -> Any:
        """The cache of its machine code, asked for when Python first calls it.

        To make one, numba writes a file to its folder, and most functions are never called so.
        """
        if self._known_cache is None:
            self._known_cache = cache_of(self.py_func)
        return self._known_cache

    @_cache.setter
    def _cache(self, cache: Any) -> None:
        self._known_cache = cache

    @cached_property
    def _linked(self) -> Any:
        """The same function as IR, made where something must be compiled."""
        linked = _Dispatcher(self.py_func, {}, self._options, pipeline_class=_LinkedCompiler)
        linked._cache = cache_of(self.py_func, _LinkedCache)
        return linked

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the types of a call from compiled code, for numba."""
        return self._linked.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return what compiled code calls, for numba."""
        return self._linked.get_overload(sig)

    def _executable(self, args: Any, _return_type: Any) -> Any:
        """Make machine code of the IR for these types of arguments."""
        self._linked.compile(args)
        linked = self._linked.overloads[args]
        context, described = linked.target_context, linked.fndesc
        context.refresh()  # for the wrapper, where the IR was on disk
        library = _ExecutableLibrary(context.codegen(), described.qualname)
        library.enable_object_caching()
        library.add_linking_library(linked.library)
        context.create_cpython_wrapper(
            library, described, linked.environment, linked.call_helper, release_gil=True
        )
        entry = context.get_executable(library, described, linked.environment)
        made = linked._replace(library=library, entry_point=entry, metadata={})
        for environment in made._find_referenced_environments():  # of what is linked into it
            library.codegen.set_env(environment.env_name, environment)
        return made


class _ExecutableLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Machine code of a function that Python calls.

    numba keeps the IR beside it, for other functions to be compiled with, and parses it whenever
    the code is loaded. Here those functions have IR of their own: names are enough.
    """

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Return the code for the disk cache, in numba's form."""
        self._ensure_finalized()
        names = _names_in(self._get_module_for_linking())
        return self.name, "object", (self._get_compiled_object(), names.as_bitcode())


def _names_in(module: Any) -> Any:
    """Return a module that defines what another one defines for others, all of it empty."""
    own = (llvm.Linkage.internal, llvm.Linkage.private)
    functions, variables = (
        [value.name for value in values if not value.is_declaration and value.linkage not in own]
        for values in (module.functions, module.global_variables)
    )
    lines = [f'define void @"{name}"() {{ unreachable }}' for name in functions]
    lines += [f'@"{name}" = global ptr null' for name in variables]
    return llvm.parse_assembly("\n".join(lines))


class LinkedLibrary(JITCodeLibrary):  # type: ignore[misc]
    """LLVM IR of a function and all that it calls, neither optimised nor compiled further."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """Return the IR for the disk cache, in numba's form."""
        return self.name, "bitcode", self._get_module_for_linking().as_bitcode()

    @classmethod
    def of(cls, codegen: Any, state: tuple[str, str, bytes]) -> LinkedLibrary:
        """Return the library that was serialised."""
        name, _, bitcode = state
        library = cls(codegen, name)
        library._final_module = library._shared_module = llvm.parse_bitcode(bitcode)
        library._finalize_final_module()
        return library


@register_pass(mutates_CFG=True, analysis_only=False)
class _LinkedLowering(NativeLowering):  # type: ignore[misc]
    """Lowers a function to LLVM IR that is not compiled further."""

    _name = "linked_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = LinkedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = state.flags.no_cpython_wrapper = True
        super().run_pass(state)
        state.library.finalize()
        lowered = state["cr"]
        name = _uncallable(state.library, lowered.fndesc, lowered.env)
        state.targetctx.insert_user_function(name, lowered.fndesc, [state.library])
        state.reload_init.extend(state.library._reload_init)
        state["cr"] = lowered._replace(cfunc=name)
        return True


class _LinkedCompiler(CompilerBase):  # type: ignore[misc]
    """numba's compiler, up to LLVM IR."""

    def define_pipelines(self) -> list[Any]:
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (_LinkedLowering if each is NativeLowering else each, what)
            for each, what in passes.passes
        ]
        passes.finalize()
        return [passes]


def _uncallable(library: LinkedLibrary, described: Any, environment: Any) -> Any:
    """Return an object that stands for a function without machine code."""
    name = described.qualname.rpartition(".")[2]
    what = f"LLVM IR of {described.qualname!r}"
    module = described.lookup_module()
    # 0: address of a function that has no machine code
    return _dynfunc.make_function(module, name, what, 0, environment, (library,))


class _LinkedResults(CompileResultCacheImpl):  # type: ignore[misc]
    """Puts together what the disk cache keeps of a compilation to LLVM IR."""

    def rebuild(self, context: Any, payload: Any) -> Any:
        """Return the result of a compilation that ``CompileResult._reduce`` took apart."""
        library, described, environment, signature, objectmode, lifted, annotation, *rest = payload
        reloads, environments = rest
        for reload in reloads or ():
            reload()
        made = LinkedLibrary.of(context.codegen(), library)
        return CompileResult(
            typing_context=context.typing_context,
            target_context=context,
            entry_point=_uncallable(made, described, environment),
            typing_error=None,
            type_annotation=annotation,
            signature=signature,
            objectmode=objectmode,
            lifted=lifted,
            fndesc=described,
            library=made,
            call_helper=None,
            environment=environment,
            metadata=None,
            reload_init=reloads,
            referenced_envs=environments,
        )


class _LinkedCache(SealedCache):
    """The cache of a function's LLVM IR, for all its signatures."""

    _impl_class = _LinkedResults
    _mark = ".linked"
