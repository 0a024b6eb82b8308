"""What every mesh of a solid can do."""

from abc import abstractmethod
from functools import lru_cache
from typing import Self

from pydantic import model_validator

from pellucid.geometry.mesh_files import FileState, states_of_files
from pellucid.geometry.most_points import refuse_too_many
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.model import Model


class Tetrahedral(Model):
    """A mesh of tetrahedra of a case."""

    @model_validator(mode="after")
    def _can_be_held(self) -> Self:
        refuse_too_many(self.expected_points())
        return self

    @abstractmethod
    def expected_points(self) -> float:
        """About how many nodes it has, found without making them."""

    @abstractmethod
    def make(self) -> SimplexMesh:
        """Its nodes and tetrahedra. Raises ValueError where there can be none."""

    def mesh(self) -> SimplexMesh:
        """Its nodes and tetrahedra, made once while the files that it names do not change; whoever asks shares them, so
        nobody writes to them."""
        return _made(self, states_of_files(self))


@lru_cache(maxsize=8)
def _made(source: Tetrahedral, _states: tuple[FileState, ...]) -> SimplexMesh:
    return source.make()
