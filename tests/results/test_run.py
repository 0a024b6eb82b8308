"""A run in the hands of its user: tables, datasets, scenes, figures, a face in notebooks."""

import numpy as np
import pytest

import pellucid
from pellucid.errors import UsageError
from pellucid.geometry.meshes.cells import Cells
from pellucid.results import run as faces
from pellucid.system import extras


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """A run of a block of tetrahedra that is thrown, with a probe."""
    body = {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": (0, 0, 0), "upper": (2e-2, 3e-2, 1e-2), "cells": (2, 3, 1)}},
        "approximant": {"kind": "linear-simplex"},
        "points_per_cell": 1,
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3},
        "velocity": (1.0, 0.0, 0.0),
    }
    probe = {"name": "place", "body": "block", "quantity": "position", "component": "x"}
    table = {"schema": 1, "title": "A <block>", "time": {"end": 1e-2}, "body": [body], "probe": [probe]}
    return pellucid.run(pellucid.Case.model_validate(table), out=tmp_path_factory.mktemp("face") / "run", report=False)


def test_the_history_is_a_table_over_time_with_units(block):
    table = block.to_pandas()
    assert table.index.name == "time"
    assert table["place"].iloc[-1] == block.history["place"][-1]
    assert table.attrs["units"]["place"] == "m"


def test_fields_are_a_dataset_over_time_points_and_components(block):
    data = block.to_xarray("block", ("position", "velocity", "stress"))
    assert data["position"].dims == ("time", "point", "axis")
    assert data["velocity"].attrs["units"] == "m/s"
    end = data["position"].sel(axis="x").isel(time=-1)
    assert np.array_equal(end, block.fields("block")["position"][:, 0])
    assert float(data["stress"].sel(axes="xy").max()) == block_extreme(block)


def block_extreme(run):
    return max(run.fields("block", float(time))["stress"][:, 5].max() for time in run.times("block"))


@pytest.mark.vtk
def test_a_body_is_a_scene_of_vtk(block):
    pyvista = pytest.importorskip("pyvista")
    grid = block.to_pyvista("block", 0.0)
    assert grid.cells_dict[pyvista.CellType.TETRA].tolist() == block.cells("block").tetrahedra.tolist()
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(6e-6)
    assert "velocity" in grid.point_data


def test_columns_are_plotted_with_their_units(block):
    figure = block.plot("place", "kinetic_energy")
    assert [axes.get_ylabel() for axes in figure.axes] == ["place [m]", "kinetic energy [J]"]
    (axes,) = block.plot().axes
    assert axes.get_ylabel() == "place [m]"
    with pytest.raises(UsageError, match="plaice"):
        block.plot("plaice")


def test_in_a_notebook_it_is_a_frame_with_the_view(block):
    html = block._repr_html_()
    assert html.startswith("<iframe")
    assert "A &amp;lt;block&amp;gt;" in html, "as text within the page within the frame"
    assert "pellucid-view" in html
    assert repr(block).startswith("Run(")


def test_a_case_has_a_face(block):
    case = block.case
    assert repr(case) == "Case('A <block>', bodies block, to t = 0.01 s)"
    assert "A &lt;block&gt;" in case._repr_html_()


def test_what_is_not_installed_is_told_with_its_extra(block, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name, name=name)

    monkeypatch.setattr(extras, "import_module", missing)
    for convert in (block.to_pandas, lambda: block.to_xarray("block"), lambda: block.to_pyvista("block")):
        with pytest.raises(UsageError, match=r"pip.* install '\.\[notebook\]' in the clone"):
            convert()


def test_a_loop_over_a_simulation_goes_to_the_end(block):
    times = [state.time for state in pellucid.Simulation(block.case, threads=1)]
    assert len(times) > 3
    assert np.all(np.diff(times) > 0.0)
    assert times[-1] == pytest.approx(1e-2)


@pytest.mark.vtk
def test_all_kinds_of_cells_are_those_of_vtk():
    kinds = pytest.importorskip("pyvista").CellType
    names = ("VERTEX", "LINE", "TRIANGLE", "QUAD", "TETRA")
    assert tuple(int(kinds[name]) for name in names) == faces.VTK_CELLS
    assert Cells._fields == ("points", "lines", "triangles", "quadrilaterals", "tetrahedra")


def test_progress_is_shown_where_it_is_asked_for(block, capfd):
    pellucid.run(block.case, report=False, progress=True)
    assert "Traceback" not in capfd.readouterr().err
