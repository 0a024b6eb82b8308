"""Keys of mesh files in a case, shared by surfaces and solids, and data by which a changed file is recognized."""

from pathlib import Path

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.files.abaqus_keywords import included_files
from pellucid.geometry.files.read import check_there
from pellucid.model import InputFile, Model, Vector, check, parameter

FileState = tuple[str, int, int]
"""Path, time of the last change [ns], length [bytes]."""


class MeshFile(Model):
    """A mesh file and its unit of length."""

    path: InputFile = parameter("", "mesh file; a relative path is relative to the folder of the case")
    unit: str | None = parameter("", 'unit of length of the file, such as "mm"; alternative to `scale`', None)
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "vector added to the scaled positions", (0.0, 0.0, 0.0))
    repair: bool = parameter("", "repair faults of the mesh if possible, and report the changes as warnings", False)

    @check
    def _has_one_unit(self) -> None:
        if self.unit is not None and self.scale != 1.0:
            text = f"`unit` and `scale` both define the unit of the file: {self.unit} and {self.scale:g} m"
            raise Refusal(text, "remove `unit` or `scale`")
        self.placed(np.zeros((1, 3)))

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Return points of the file in metres, shape (n, 3), shifted by `offset`. Raises ValueError if `unit` is not a
        length."""
        if self.unit is None:
            return points * self.scale + np.array(self.offset)
        from pellucid.units import to_si

        return points * to_si(f"1 {self.unit}", "m") + np.array(self.offset)


def states_of_files(model: Model) -> tuple[FileState, ...]:
    """Return path, modification time [ns] and size [bytes] of each file that a key `path` in a model and its submodels
    names, and of the files that these include. Raises ValueError for a missing file."""
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
