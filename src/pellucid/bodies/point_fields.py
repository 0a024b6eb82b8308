"""Fields, order and number of the points of a body on the grid, some of which may have left the grid."""

import numpy as np

from pellucid.grid.shared_points import SpreadPoints, WholePoints
from pellucid.parts.families import GridBody
from pellucid.ranks.domain import domain
from pellucid.state import FIELDS, parts_of


class PointFields(GridBody):
    """Base class of bodies of points on the grid: fields of the points for results.

    Points are sorted by slabs (layers of grid cells); the first `n_there` rows of the arrays are the points that have not left
    the grid.
    """

    shared: SpreadPoints | WholePoints
    """Distribution of the points among processes."""

    def __init__(self) -> None:
        self._orders = dict[str, np.ndarray]()

    @property
    def n_there(self) -> int:
        """Number of points that have not left the grid; they are stored first and belong to slabs.

        The points after them have no mass. If the points are distributed among processes, the number on this process.
        """
        return int(self.shared.first[-1])

    def order(self) -> np.ndarray:
        """Return the storage rows of the points present, sorted by point number, shape (n_there,); computed once between
        sortings.
        """
        if domain.joins not in self._orders:
            self._orders[domain.joins] = np.argsort(self.shared.joined(self._there("id")))
        return self._orders[domain.joins]

    def _complete(self, *names: str) -> None:
        """Fill, in the arrays with these names, the rows of points that other processes computed; nothing to do in a run with
        one process.
        """
        for name in names if domain.is_cut else ():
            self.shared.fill(self._there(name))

    @property
    def field_names(self) -> list[str]:
        return [name for name in self.arrays if FIELDS[name].shown] + ["density", "pressure"]

    def field(self, name: str) -> np.ndarray:
        try:
            stored = self.stored_field(name)
        except KeyError:
            raise self.no_field(name) from None
        return stored[self.order()]

    def stored_field(self, name: str) -> np.ndarray:
        self._complete(*([name, *parts_of(name, self.arrays)] if name in self.arrays else self.arrays))
        return self.shared.joined(self._field_there(name))

    def stored_array(self, name: str) -> np.ndarray:
        self._complete(name)
        return self.shared.joined(self._there(name))

    def _field_there(self, name: str) -> np.ndarray:
        """Return a field of the points of this process, by name, in storage order."""
        if name == "density":
            return self._there("mass") / self._there("volume")
        if name == "pressure":
            return np.asarray(-self._there("stress")[:, :3].mean(axis=1))
        if name == "kinetic_energy":
            return self.kinetic_energies()[: self.n_there]
        if name == "stored_energy":
            return self._there("mass") * self._there("strain_energy")
        return sum((self._there(part) for part in parts_of(name, self.arrays)), self._there(name))

    def _there(self, name: str) -> np.ndarray:
        return self.arrays[name][: self.n_there]

    def frame(self) -> dict[str, np.ndarray]:
        """Return the fields of all points by name, as recorded in a frame of the results, in the order of point numbers. For
        points that left, the fields are zero, except the position at which they left the grid.
        """
        fields, left = super().frame(), self.arrays["id"][self.n_there :]
        if not len(left) or (domain.is_cut and self.shared.is_spread):  # those behind are with other processes
            return fields
        there = fields["id"]
        for name, values in fields.items():
            fields[name] = np.zeros((self.n_points, *values.shape[1:]), values.dtype)
            fields[name][there] = values
        for name in ("id", "position"):
            fields[name][left] = self.arrays[name][self.n_there :]
        return fields
