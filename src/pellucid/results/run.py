"""Results of a run for users: in a notebook, as a pandas table, as an xarray dataset, or as a VTK scene."""

from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import UsageError
from pellucid.results.report.html import facts, header, page_of
from pellucid.results.storage.run import Run as StoredRun
from pellucid.state import COMPONENT_NAMES, FIELDS
from pellucid.system.extras import needed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

need = partial(needed, extra="notebook", what="tables, datasets and scenes")
FRAME = '<iframe srcdoc="{page}" style="width:100%;height:1000px;border:0" allow="fullscreen"></iframe>'
VTK_CELLS = (1, 3, 5, 9, 10)
"""VTK cell types of the entries of `Cells`: vertices, lines, triangles, quadrilaterals, tetrahedra."""


class Run(StoredRun):
    """Results of a run in a folder; files are read on first use. Attributes and methods: columns of the history (`history`,
    arrays of shape (rows,)) and their `units`; `fields(body, time)`, arrays of shape (n,), (n, 3) or (n, 6) in SI units;
    `metrics`; `summary`."""

    def to_pandas(self) -> Any:
        """Return the history as a `pandas.DataFrame` with the time [s] as index and the units of the columns in
        `attrs["units"]`.

        Raises `UsageError` if pandas is not installed.
        """
        table = need("pandas").DataFrame(dict(self.history)).set_index("time")
        table.attrs["units"] = dict(self.units)
        return table

    def to_xarray(self, body: str, names: "tuple[str, ...] | None" = None) -> Any:
        """Return the fields of a body at all frames as an `xarray.Dataset`.

        Dimensions are `time` [s], `point` and, for vectors and tensors, the components. Each field has the attribute
        `units`. names: fields to include; default: all.

        Raises `UsageError` if xarray is not installed, and for a body or field that the run does not have.
        """
        xarray, times = need("xarray"), self.times(body)
        frames = [self.fields(body, float(time), names) for time in times]
        data = {}
        for name, first in frames[0].items():
            field, rest = FIELDS.get(name), first.shape[1:]
            axes = ("time", "point", *(dimension(name, n) for n in rest))
            attributes = {"units": field.unit, "long_name": field.meaning} if field is not None else {}
            data[name] = (axes, np.stack([frame[name] for frame in frames]), attributes)
        coordinates: dict[str, Any] = {"time": ("time", times, {"units": "s"})}
        for name, (axes, *_) in data.items():
            if len(axes) > 2 and name in FIELDS and FIELDS[name].names:
                coordinates[axes[2]] = list(FIELDS[name].names)
        return xarray.Dataset(data, coordinates, {"body": body, "title": self.stored.title})

    def to_pyvista(self, body: str, time: float | None = None) -> Any:
        """Return a body as a `pyvista.UnstructuredGrid` of its points, elements or tetrahedra, with its fields.

        time: time [s]; the nearest frame is used; default: the last frame.

        Raises `UsageError` if pyvista is not installed, and for a body that the run does not have.
        """
        fields = dict(self.fields(body, time))
        elements = {kind: corners for kind, corners in zip(VTK_CELLS, self.cells(body), strict=True) if len(corners)}
        grid = need("pyvista").UnstructuredGrid(elements, fields.pop("position").astype(float))
        for name, values in fields.items():
            grid.point_data[name] = values
        return grid

    def plot(self, *columns: str, x: str = "time") -> "Figure":
        """Return a matplotlib figure of columns of the history against time or another column; default: all probes.

        Raises `UnknownName` for a column that the history does not have, and `UsageError` if there is nothing to plot.
        """
        from pellucid.results.pictures import figures
        from pellucid.results.pictures.style import house_style

        names = columns or tuple(self.stored.probes)
        if not names:
            raise UsageError("The case has no probes.\n    Pass names of columns of the history, such as kinetic_energy.")
        with house_style():
            return figures.columns(self, names, x)

    def _repr_html_(self) -> str:
        """Return the run as HTML for a notebook: outcome, checks and interactive view."""
        from pellucid.results.report.report import metrics_table
        from pellucid.results.view.page import view_of

        checks = metrics_table(self.metrics) if self.metrics else ""
        page = page_of(self.stored.title, header(self) + facts(self) + checks + view_of(self))
        return FRAME.format(page=escape(page))


def dimension(name: str, components: int) -> str:
    """Return the name of the component axis that a field `name` with a number of components has in an xarray dataset.

    Vectors and tensors in space share the names "axis", "axes" and "row_by_row" (3, 6, 9 components); every other field has
    its own axis name.
    """
    along = COMPONENT_NAMES.get(components)
    is_along_axes = along is not None and (name not in FIELDS or FIELDS[name].names == along)
    return {3: "axis", 6: "axes", 9: "row_by_row"}[components] if is_along_axes else f"component_of_{name}"
