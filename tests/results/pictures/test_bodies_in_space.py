import numpy as np
import pytest
import synthetic_oocyte
from matplotlib.colors import to_hex

from pellucid import run
from pellucid.case import Case
from pellucid.errors import UsageError
from pellucid.results.pictures.bodies_in_space import opening
from pellucid.results.pictures.camera import round_length
from pellucid.results.pictures.figures import bodies, columns, energies, figures_of
from pellucid.results.pictures.own import bodies_at
from pellucid.results.pictures.quantities import Look, Slice
from pellucid.results.pictures.style import COLOURS, house_style


def box(lower, upper):
    return np.random.default_rng(2).uniform(lower, upper, (50, 3)).clip(lower, upper)


def test_what_surrounds_another_body_is_opened_in_its_middle():
    outer, inner = box(0.0, 10.0), box(2.0, 6.0)
    plane = opening([outer, inner])
    middle = 0.5 * (inner.min(axis=0) + inner.max(axis=0))
    assert -0.01 < plane.beyond(middle[None])[0] < 0.0, "a layer in the middle stays"
    assert plane.beyond(middle[None] - [0.0, 1.0, 0.0]) == pytest.approx(1.0, abs=0.01), "the front goes"


def test_bodies_side_by_side_stay_whole():
    assert opening([box(0.0, 1.0), box(2.0, 3.0)]) is None
    assert opening([box(0.0, 1.0)]) is None


@pytest.mark.parametrize("quantity", ["speed", "load"])
def test_a_run_in_space_is_drawn(tmp_path, monkeypatch, quantity):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 150)
    run = synthetic_oocyte.write(tmp_path / "run", spacing=15.0, instants=2)
    with house_style():
        figure = bodies_at(run, Look(quantity))
    pictures = [axes.images[0].get_array() for axes in figure.axes if axes.images]
    assert len(pictures) == 2
    assert not np.allclose(*pictures)
    texts = [text.get_text() for text in figure.axes[1].texts]
    assert "t = 100 µs" in texts
    assert "cut open" in texts


def test_lines_are_left_out_beside_surfaces(tmp_path, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 150)
    shapes = {
        "revolved": {"spheroid": {"radius": 1.0, "nodes": 9}},
        "in-space": {"surface": {"icosphere": {"centre": (0, 0, 0), "radius": 1.0, "refinements": 1}}},
    }
    material = {"kind": "lipid-film", "density": 1.0, "viscosity": 1.0, "dilatational_viscosity": 1.0, "stiffness": 1.0}
    film = {"kind": "fluid-film", "material": material, "density": 1.1}
    films = [{"name": name, "shape": shape, **film} for name, shape in shapes.items()]
    case = Case.model_validate({"schema": 1, "title": "Two films", "time": {"end": 0.1}, "body": films})
    with house_style():
        figure = bodies_at(run(case, out=tmp_path / "run", report=False), Look("speed"))
    assert any(axes.images for axes in figure.axes)


def thrown(**more):
    """A case of a block of tetrahedra that is thrown."""
    body = {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": (0, 0, 0), "upper": (2e-2, 3e-2, 1e-2), "cells": (2, 3, 1)}},
        "approximant": {"kind": "linear-simplex"},
        "points_per_cell": 1,
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3},
        "velocity": (1.0, 0.0, 0.0),
    }
    table = {"schema": 1, "title": "A block", "time": {"end": 1e-2}, "gravity": (0, 0, -9.81), "body": [body]}
    return Case.model_validate(table | more)


@pytest.fixture(scope="module")
def solid(tmp_path_factory):
    """A run of such a block."""
    return run(thrown(), out=tmp_path_factory.mktemp("solid") / "run", report=False)


def test_solids_are_drawn_whole_and_cut_open(solid, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 150)
    with house_style():
        drawn = {name: draw() for name, draw in bodies(solid).items()}
    assert list(drawn) == ["bodies_speed", "bodies_load", "bodies_speed_inside", "bodies_load_inside"]
    words = {name: {text.get_text() for axes in figure.axes for text in axes.texts} for name, figure in drawn.items()}
    assert {name: "cut open" in found for name, found in words.items()} == {name: "inside" in name for name in words}
    covered = {
        name: np.mean([axes.images[0].get_array()[:, :, 3].mean() for axes in figure.axes if axes.images])
        for name, figure in drawn.items()
    }
    assert min(covered.values()) > 0.1
    assert not np.allclose(covered["bodies_speed"], covered["bodies_speed_inside"])


def test_a_solid_at_a_plane_of_symmetry_in_front_is_not_cut_open(tmp_path, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 100)
    grid = {"lower": (-1e-2, 0.0, -1e-2), "upper": (5e-2, 4e-2, 3e-2), "cell": 1e-2}
    case = thrown(grid=grid, support=[{"where": "y-lower", "fix": "normal"}])
    at_the_face = run(case, out=tmp_path / "run", report=False)
    with house_style():
        assert list(bodies(at_the_face)) == ["bodies_speed", "bodies_load"]


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    """Two steady states of a block that hangs by its top."""
    body = {
        "name": "block",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": (0, 0, 0), "upper": (2e-2, 3e-2, 1e-2), "cells": (2, 3, 1)}},
        "approximant": {"kind": "linear-simplex"},
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3},
    }
    table = {"schema": 1, "title": "A block", "time": {"end": 1.0}, "gravity": (0, 0, -9.81), "body": [body]}
    steady = {"steady": {"method": "relaxation", "load_steps": 2, "tolerance": 1e-4}}
    steady["support"] = [{"name": "top", "where": {"normal": (0, 0, 1)}}]
    probe = {"name": "pull", "quantity": "reaction", "condition": "top", "component": "z"}
    case = Case.model_validate(table | steady | {"probe": [probe]})
    return run(case, out=tmp_path_factory.mktemp("steady") / "run", report=False)


def test_steady_states_are_coloured_by_displacement_and_their_curves_go_over_the_loads(hanging, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 150)
    drawn = set(figures_of(hanging, None, []))
    assert drawn == {
        *(f"bodies_{what}{cut}" for what in ("displacement", "load") for cut in ("", "_inside")),
        "energies",
        "probes",
    }
    with house_style():
        picture, curves, reaction = (
            bodies_at(hanging, Look("displacement")),
            energies(hanging),
            columns(hanging, hanging.stored.probes),
        )
    first, *_, last = (axes.images[0].get_array() for axes in picture.axes if axes.images)
    assert not np.allclose(first, last)
    assert picture.axes[-1].get_ylabel() == "displacement [m]"
    end = np.linalg.norm(hanging.fields("block")["position"] - hanging.fields("block", 0.0)["position"], axis=1).max()
    assert picture.axes[-1].get_ylim()[1] == pytest.approx(end, rel=0.05)
    left = curves.axes[0]
    assert left.get_xlabel() == "load time [s]"
    assert {line.get_label() for line in left.lines} == {"strain", "gravity work"}
    (legend,) = curves.legends
    assert "damping\u00a0heat" in legend.get_title().get_text(), "which is below a thousandth of these"
    (line,) = reaction.axes[0].lines
    assert line.get_xdata() == pytest.approx([0.0, 0.5, 1.0])
    assert line.get_marker() == "o"
    assert line.get_ydata()[-1] == pytest.approx(9.81 * 6e-3, rel=1e-2)


@pytest.mark.vtk
def test_fields_of_solids_open_in_pyvista(solid):
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(solid.folder.fields("block"))
    reader.reader.SetStep(len(solid.times("block")) - 1)  # pyvista 0.49 has no instants of its own for these files
    grid = reader.read()
    assert isinstance(grid, pyvista.UnstructuredGrid)
    assert grid.cells_dict[pyvista.CellType.TETRA].tolist() == solid.cells("block").tetrahedra.tolist()
    fields = solid.fields("block")
    assert np.array_equal(grid.points, fields["position"])
    assert grid.point_data["velocity"] == pytest.approx(fields["velocity"])
    assert {"stress", "pressure", "density", "strain_energy"} <= set(grid.point_data.keys())
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(6e-6, rel=1e-3), "no tetrahedron is inside out"


@pytest.mark.parametrize(
    ("most", "length", "text"),
    [(2.7e-5, 2e-5, "20 µm"), (0.99e-3, 5e-4, "500 µm"), (1e-3, 1e-3, "1 mm"), (0.7, 0.5, "500 mm"), (30.0, 20.0, "20 m")],
)
def test_round_lengths(most, length, text):
    found, name = round_length(most)
    assert found == pytest.approx(length)
    assert name == text


def test_a_slice_shows_what_lay_beside_a_plane_at_the_start(tmp_path):
    """Each body in a colour of its own, with its images."""
    oocyte = synthetic_oocyte.write(tmp_path / "run", spacing=15.0, instants=2)
    start = oocyte.fields("zona", 0.0)["position"]
    middle = float(np.median(start[:, 2]))
    with house_style():
        figure = bodies_at(oocyte, Look("bodies", slice=Slice(2, middle, 8e-6)))
    panel = figure.axes[0]
    shown = {to_hex(dots.get_facecolor()[0]): len(dots.get_offsets()) for dots in panel.collections if len(dots.get_offsets())}
    names = [body.name for body in oocyte.stored.bodies]
    assert shown[COLOURS[names.index("zona")].lower()] == np.sum(np.abs(start[:, 2] - middle) <= 8e-6)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == names


def test_a_slice_beside_everything_is_told(tmp_path):
    oocyte = synthetic_oocyte.write(tmp_path / "run", spacing=15.0, instants=2)
    with pytest.raises(UsageError, match="slice contains no points"):
        bodies_at(oocyte, Look("bodies", slice=Slice(2, 1.0, 1e-6)))


def test_bodies_in_space_have_a_colour_each(tmp_path, monkeypatch):
    monkeypatch.setattr("pellucid.results.pictures.bodies_in_space.COLUMNS", 100)
    oocyte = synthetic_oocyte.write(tmp_path / "run", spacing=15.0, instants=2)
    with house_style():
        figure = bodies_at(oocyte, Look("bodies"))
    assert len(figure.legends) == 1
