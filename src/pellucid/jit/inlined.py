"""Compilation of helper functions to intermediate code that is linked into kernels, without machine code of their own."""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class _NoEnvironments:
    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        pass


class InlinedLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Library of compiled code that is only linked into other libraries."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code to which a pointer could refer."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """Substitute for the code generator of numba. Numba would register objects of the Python interpreter (environments)
        with it, which code without machine code does not need."""
        return _NoEnvironments


class InlinedCompiler(Compiler):  # type: ignore[misc]
    """Compiler that produces an `InlinedLibrary`."""

    def compile_extra(self, function: Any) -> Any:
        """Compile a function to intermediate code that is linked into kernels; generate no machine code."""
        self.state.library = InlinedLibrary(self.state.targetctx.codegen(), function.__qualname__)
        return super().compile_extra(function)
