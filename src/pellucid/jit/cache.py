"""Compiled kernels on disk, one file for each kernel, types of arguments and state of the sources that these depend on.

Numba's own cache looks at the file of the kernel alone, and refers to classes in ways that other processes cannot follow where
they come from a script or from a module that is not there.
"""

import contextlib
import hashlib
import os
import pickle
import tempfile
from pathlib import Path
from types import FunctionType
from typing import Any

from numba.core import types
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import NumbaPickler
from numba.core.sigutils import normalize_signature
from numba.np.ufunc.parallel import _launch_threads

from pellucid.jit.folder import cache_folder
from pellucid.jit.parallel import ChunkKernel, chunk_kernels
from pellucid.jit.registry import kernels
from pellucid.jit.sources import Sources, sources_of


class KernelCache(NullCache):  # type: ignore[misc]
    """Keeps what numba compiles of one kernel. Where the folder cannot be written, kernels live as long as the process."""

    def __init__(self, function: FunctionType) -> None:
        self.function = function

    @property
    def cache_path(self) -> str:
        """Where compiled kernels are kept."""
        return str(cache_folder())

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """The kernel compiled for these types of arguments, or None."""
        sources, file = self._entry(sig, target_context)
        if sources is None:
            return None
        try:
            with file.open("rb") as stream:
                references, payload = _Unpickler(stream, sources).load()
        except (OSError, EOFError, pickle.UnpicklingError):
            return None  # compiled anew, and the file replaced
        target_context.refresh()
        _launch_threads()  # drivers refer to what it makes known
        found = [_chunk_kernel(*reference) for reference in references]
        if [chunk.symbol if chunk else None for chunk in found] != [symbol for _, _, symbol in references]:
            return None  # compiled anew, for what it refers to was
        result = CompileResult._rebuild(target_context, *payload)
        chunk_kernels(result.library).extend(chunk for chunk in found if chunk)
        return result

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Keep a kernel compiled for these types of arguments."""
        sources, file = self._entry(sig, data.target_context)
        if sources is None or data.library.has_dynamic_globals or data.lifted:
            return
        references = [
            ((chunk.function.__module__, chunk.function.__qualname__), chunk.arguments, chunk.symbol)
            for chunk in _referred_to(data.library)
        ]
        with contextlib.suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as beside:
                try:
                    _Pickler(beside, sources).dump((references, data._reduce()))
                    beside.close()
                    os.replace(beside.name, file)  # whole, whoever else writes it
                except BaseException:
                    beside.close()
                    os.unlink(beside.name)
                    raise

    def _entry(self, sig: Any, target_context: Any) -> tuple[Sources | None, Path]:
        arguments, _ = normalize_signature(sig)
        sources = sources_of([self.function], arguments)
        if sources is None:
            return None, Path()
        machine = " ".join(map(str, target_context.codegen().magic_tuple()))
        key = hashlib.sha256(f"{machine} {sources.digest}".encode()).hexdigest()[:32]
        name = self.function.__qualname__.replace("<", "").replace(">", "")
        return sources, cache_folder() / self.function.__module__ / f"{name}-{key}.nbc"


def _referred_to(library: Any) -> list[ChunkKernel]:
    """The kernels that the code of a library refers to, that of other libraries within it included."""
    inner = [chunk for linked in library._linking_libraries for chunk in _referred_to(linked)]
    return [*chunk_kernels(library), *inner]


def _chunk_kernel(name: tuple[str, str], arguments: tuple[Any, ...], symbol: str) -> ChunkKernel | None:
    """The kernel of this name for these types of arguments, from the cache or compiled."""
    compiled = kernels.get(name)
    if compiled is None:
        return None
    return ChunkKernel(compiled.py_func, arguments, compiled.get_compile_result(types.none(*arguments)))


class _Pickler(NumbaPickler):  # type: ignore[misc]
    """Refers to the named tuple classes of a kernel by name, wherever they come from."""

    def __init__(self, file: Any, sources: Sources) -> None:
        super().__init__(file, protocol=4)
        self.names = {kind: name for name, kind in sources.classes.items()}

    def persistent_id(self, thing: Any) -> tuple[str, str] | None:
        return self.names.get(thing) if isinstance(thing, type) else None


class _Unpickler(pickle.Unpickler):
    """Finds the named tuple classes of a kernel by name among those that it is called with."""

    def __init__(self, file: Any, sources: Sources) -> None:
        super().__init__(file)
        self.classes = sources.classes

    def persistent_load(self, name: tuple[str, str]) -> type:
        return self.classes[name]
