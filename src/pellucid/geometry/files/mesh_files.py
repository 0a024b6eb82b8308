"""Files of meshes in a case: what models of surfaces and of solids say of them, and the state by which a file is known."""

from pathlib import Path

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.files.abaqus_keywords import included_files
from pellucid.geometry.files.read import check_there
from pellucid.model import InputFile, Model, Vector, check, parameter

FileState = tuple[str, int, int]
"""Path, time of the last change [ns], length [bytes]."""


class MeshFile(Model):
    """A file of a mesh, and how long its unit is."""

    path: InputFile = parameter("", "the file; a relative path starts from the case file's folder")
    unit: str | None = parameter("", 'the file\'s unit of length, such as "mm"; in its place `scale` may stand', None)
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))
    repair: bool = parameter("", "mend what can be mended, and warn of what was done", False)

    @check
    def _has_one_unit(self) -> None:
        if self.unit is not None and self.scale != 1.0:
            text = f"`unit` and `scale` both say how long the file's unit is: {self.unit} and {self.scale:g} m"
            raise Refusal(text, "keep one of them")
        self.placed(np.zeros((1, 3)))

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Points of the file in metres, shape (n, 3), moved by `offset`. Raises ValueError where `unit` is no length."""
        if self.unit is None:
            return points * self.scale + np.array(self.offset)
        from pellucid.units import to_si

        return points * to_si(f"1 {self.unit}", "m") + np.array(self.offset)


def states_of_files(model: Model) -> tuple[FileState, ...]:
    """The states of all files that a model and the models in it name under the key `path`. Raises ValueError for a missing
    file."""
    states: list[FileState] = []
    for name, value in model:
        if isinstance(value, Model):
            states += states_of_files(value)
        elif name == "path":
            check_there(value)
            found = Path(value).stat()
            states.append((value, found.st_mtime_ns, found.st_size))
            for included in included_files(value) if value.lower().endswith(".inp") else []:
                inner = Path(included).stat()
                states.append((included, inner.st_mtime_ns, inner.st_size))
    return tuple(states)
