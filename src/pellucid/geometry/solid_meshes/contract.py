"""Base class of the tetrahedral meshes of a case."""

import warnings
from abc import abstractmethod
from functools import lru_cache
from typing import ClassVar

from pellucid.geometry.checks.solid_checks import apart
from pellucid.geometry.choice import Countable
from pellucid.geometry.files.read import FileState, states_of_files
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


class Tetrahedral(Countable):
    """A tetrahedral mesh of a case."""

    @abstractmethod
    def make(self) -> SimplexMesh:
        """Build the mesh: nodes and tetrahedra. Raises ValueError if it cannot be built."""

    # True if the tetrahedra follow a pattern that fills the solid, so that only coordinates can be wrong
    is_pattern: ClassVar[bool] = False

    @property
    def origin(self) -> str:
        """The path of the mesh file, for messages; empty if the mesh is generated."""
        return ""

    def mesh(self) -> SimplexMesh:
        """Return the nodes and tetrahedra, cached until a file of the case changes; warn if the mesh has unconnected pieces.

        All callers share the arrays and must not write to them.
        """
        return _made(self, states_of_files(self))


@lru_cache(maxsize=8)
def _made(source: Tetrahedral, _states: tuple[FileState, ...]) -> SimplexMesh:
    mesh = source.make()
    if not source.is_pattern and (text := apart(mesh)) is not None:
        warnings.warn(f"{source.origin}: {text}" if source.origin else text, stacklevel=2)
    return mesh
