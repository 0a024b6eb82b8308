"""Compiled kernels on disk: one file for each kernel, types of its arguments, and state of the sources that it depends on.

Numba's own cache checks only the file of the kernel. It also refers to classes in a way that other processes cannot resolve
if the classes are defined in a script or in a missing module.
"""

import contextlib
import hashlib
import io
import os
import pickle
import tempfile
import warnings
from pathlib import Path
from types import FunctionType
from typing import Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import NumbaPickler
from numba.core.sigutils import normalize_signature

from pellucid.jit.calls import LinkedKernel, compiled_for, linked_kernels
from pellucid.jit.kernel_folder import cache_folder, held
from pellucid.jit.region import make_known
from pellucid.jit.registry import kernels
from pellucid.jit.sources import Sources, sources_of

FORMAT = 2
"""Format of the files; files of other formats are ignored."""
LOCKS = "locks"
"""Name of the file whose bytes are the locks of kernels, see `pellucid.jit.kernel_folder`."""
DIGEST = 32
"""Length of a digest [bytes]."""


class NotKept(UserWarning):
    """Warning that compiled kernels are not stored on disk."""


class KernelCache(NullCache):  # type: ignore[misc]
    """Cache of one kernel on disk. If the folder cannot be written, compiled code lasts until the process ends. A file
    whose content does not match its digest is replaced. In both cases a process issues a single warning."""

    def __init__(self, function: FunctionType) -> None:
        self.function = function

    @property
    def cache_path(self) -> str:
        """Return the folder of compiled kernels."""
        return str(cache_folder())

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """Return the kernel compiled for the argument types `sig`; None if this process must compile the kernel. If another
        process is compiling the kernel, wait until the result is in the cache. target_context: numba's target context."""
        sources, file = self._entry(sig, target_context)
        if sources is None:
            return None
        found = self._read(file, sources, target_context)
        if found is None and held.lock(cache_folder() / LOCKS, file.stem.rpartition("-")[2]):
            found = self._read(file, sources, target_context)
        return found

    def _read(self, file: Path, sources: Sources, target_context: Any) -> CompileResult | None:
        try:
            data = read_checked(file)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError) as error:
            _warn_once(f"the compiled kernel {file} is damaged or cannot be read ({error}): it is compiled again")
            return None
        references, payload = _Unpickler(io.BytesIO(data), sources).load()
        target_context.refresh()
        make_known()  # drivers refer to it
        found = [_linked_kernel(*reference) for reference in references]
        if [kernel.symbol if kernel else None for kernel in found] != [symbol for _, _, symbol in references]:
            return None  # compiled anew, for what it refers to was
        result = CompileResult._rebuild(target_context, *payload)
        linked_kernels(result.library).extend(kernel for kernel in found if kernel)
        return result

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Store a kernel compiled for the argument types `sig`; data: numba's result of the compilation."""
        sources, file = self._entry(sig, data.target_context)
        if sources is None or data.library.has_dynamic_globals or data.lifted:
            return
        references = [
            ((linked.function.__module__, linked.function.__qualname__), linked.arguments, linked.symbol)
            for linked in _referred_to(data.library)
        ]
        stream = io.BytesIO()
        _Pickler(stream, sources).dump((references, data._reduce()))
        try:
            write_checked(file, stream.getvalue())
        except OSError as error:
            text = f"compiled kernels cannot be stored in {cache_folder()} ({error.strerror}), so every run compiles them again"
            _warn_once(f"{text}: free disk space, or set NUMBA_CACHE_DIR to another folder", NotKept)

    def _entry(self, sig: Any, target_context: Any) -> tuple[Sources | None, Path]:
        arguments, _ = normalize_signature(sig)
        sources = sources_of([self.function], arguments)
        if sources is None:
            return None, Path()
        machine = " ".join(map(str, target_context.codegen().magic_tuple()))
        key = hashlib.sha256(f"{FORMAT} {machine} {sources.digest}".encode()).hexdigest()[:32]
        name = self.function.__qualname__.replace("<", "").replace(">", "")
        return sources, cache_folder() / self.function.__module__ / f"{name}-{key}.nbc"


def read_checked(file: Path) -> bytes:
    """Return the data of a file that `write_checked` has written, without its digest. Raises ValueError if the data do not
    match the digest."""
    data = file.read_bytes()
    if hashlib.sha256(data[DIGEST:]).digest() != data[:DIGEST]:
        raise ValueError("its bytes do not match its digest")
    return data[DIGEST:]


def write_checked(file: Path, data: bytes) -> None:
    """Write a file that starts with the digest of its data. The file is written completely or not at all, even if other
    processes write the same file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as beside:
        try:
            beside.write(hashlib.sha256(data).digest() + data)
            beside.close()
            os.replace(beside.name, file)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(beside.name)
            raise


_said: set[str] = set()


def _warn_once(text: str, category: type[UserWarning] = UserWarning) -> None:
    """Issue the first warning of the process and ignore later ones: usually many kernels have the same problem."""
    if not _said:
        _said.add(text)
        warnings.warn(text, category, stacklevel=2)


def _referred_to(library: Any) -> list[LinkedKernel]:
    """Return the kernels that the code of a compiled library refers to by name, including nested libraries."""
    inner = [kernel for part in library._linking_libraries for kernel in _referred_to(part)]
    return [*linked_kernels(library), *inner]


def _linked_kernel(name: tuple[str, str], arguments: tuple[Any, ...], symbol: str) -> LinkedKernel | None:
    """Return the kernel with this name for these argument types, from the cache or newly compiled; None if there is none."""
    compiled = kernels.get(name)
    return None if compiled is None else compiled_for(compiled, arguments)


class _Pickler(NumbaPickler):  # type: ignore[misc]
    """Pickler that stores the named tuple classes of a kernel by name, wherever they are defined."""

    def __init__(self, file: Any, sources: Sources) -> None:
        super().__init__(file, protocol=4)
        self.names = {kind: name for name, kind in sources.classes.items()}

    def persistent_id(self, thing: Any) -> tuple[str, str] | None:
        return self.names.get(thing) if isinstance(thing, type) else None


class _Unpickler(pickle.Unpickler):
    """Unpickler that looks up the named tuple classes of a kernel among the classes of its arguments."""

    def __init__(self, file: Any, sources: Sources) -> None:
        super().__init__(file)
        self.classes = sources.classes

    def persistent_load(self, name: tuple[str, str]) -> type:
        return self.classes[name]
