"""What every mesh of a solid can do."""

import warnings
from abc import abstractmethod
from functools import lru_cache
from typing import ClassVar

from pellucid.geometry.checks.solid_checks import apart
from pellucid.geometry.files.mesh_files import FileState, states_of_files
from pellucid.geometry.meshes.most_points import Countable
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


class Tetrahedral(Countable):
    """A mesh of tetrahedra of a case."""

    @abstractmethod
    def make(self) -> SimplexMesh:
        """Its nodes and tetrahedra. Raises ValueError where there can be none."""

    # whether its tetrahedra follow a pattern that fills the solid: then coordinates alone can be wrong
    is_pattern: ClassVar[bool] = False

    @property
    def origin(self) -> str:
        """The file whose tetrahedra they are, for messages; empty where they are made here."""
        return ""

    def mesh(self) -> SimplexMesh:
        """The nodes and tetrahedra, made once while the files that the case names do not change. All callers share the arrays,
        so none may write to them. Warns of pieces that do not hold together."""
        return _made(self, states_of_files(self))


@lru_cache(maxsize=8)
def _made(source: Tetrahedral, _states: tuple[FileState, ...]) -> SimplexMesh:
    mesh = source.make()
    if not source.is_pattern and (text := apart(mesh)) is not None:
        warnings.warn(f"{source.origin}: {text}" if source.origin else text, stacklevel=2)
    return mesh
