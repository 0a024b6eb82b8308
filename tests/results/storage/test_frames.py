import resource
import time as clock

import h5py
import numpy as np
import pytest
from endless_writers import POINTS, append_frames, frame
from other_processes import killed_at_last

from pellucid.geometry.meshes.cells import Cells
from pellucid.results.storage import frames
from pellucid.results.storage.files import OutputError
from pellucid.results.storage.vtkhdf import counting


def same(one, other) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "gas.vtkhdf"
    frames.create(path, 4, 0.0, frame(0))
    for k in (1, 2):
        frames.append(path, 0.5 * k, frame(k))
    return path


def test_frames_come_back_exactly(path):
    assert frames.times(path).tolist() == [0.0, 0.5, 1.0]
    for k in range(3):
        assert same(frames.read(path, k), frame(k))
    assert same(frames.read(path, -1), frame(2))


def test_chosen_fields_come_back_alone(path):
    found = frames.read(path, 1, ("stress", "position", "nosuch"))
    assert list(found) == ["stress", "position"]
    assert same(found, {name: frame(1)[name] for name in found})


def test_masses_of_a_fluid_film_are_those_of_each_frame(tmp_path):
    path = tmp_path / "film.vtkhdf"
    films = [frame(k) | {"mass": np.full(POINTS, 1.0 + k), "areal_density": np.ones(POINTS)} for k in range(4)]
    frames.create(path, 2, 0.0, films[0])
    for k in (1, 2, 3):  # beyond the room that was foreseen
        frames.append(path, 0.5 * k, films[k])
    assert all(same(frames.read(path, k), film) for k, film in enumerate(films))


def test_a_frame_that_is_not_there_is_an_index_error(path):
    with pytest.raises(IndexError, match="has 3 frames"):
        frames.read(path, 3)


def test_more_frames_than_foreseen_make_room(path):
    for k in (3, 4, 5):
        frames.append(path, 0.5 * k, frame(k))
    assert frames.times(path).tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    assert all(same(frames.read(path, k), frame(k)) for k in range(6))


def test_cut_back_and_written_again_is_the_same_file(path):
    frames.append(path, 1.5, frame(3))
    whole = path.read_bytes()
    frames.cut(path, 2)
    assert frames.times(path).tolist() == [0.0, 0.5]
    for k in (2, 3):
        frames.append(path, 0.5 * k, frame(k))
    assert path.read_bytes() == whole


def test_too_few_frames_for_the_checkpoint_are_an_error(path):
    with pytest.raises(OutputError, match="fewer than the 4 frames"):
        frames.cut(path, 4)


def test_the_file_holds_what_its_format_asks_for(path):
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"PolyData"
        assert root["Steps"].attrs["NSteps"] == len(root["Steps/Values"]) == 3
        assert root["PointData/position"] == root["Points"]
        assert root["PointData/density"].attrs["unit"] == "kg/m^3"
        assert root["PointData/density"].attrs["meaning"]
        assert root["PointData/mass"].shape == (POINTS,), "what never changes is stored once"
        stress = frame(1)["stress"]
        stored = root["PointData/stress"][POINTS : 2 * POINTS]
        for column, component in enumerate(("xx", "yy", "zz", "xy", "yz", "xz")):
            ours = ("xx", "yy", "zz", "yz", "xz", "xy").index(component)
            assert np.array_equal(stored[:, column], stress[:, ours])


def test_places_not_yet_written_take_no_room(tmp_path):
    path = tmp_path / "long.vtkhdf"
    frames.create(path, 100_000, 0.0, frame(0))
    status = path.stat()
    assert status.st_size > 100_000 * POINTS * 13 * 8
    assert status.st_blocks * 512 < 20_000_000


def test_a_disk_without_room_is_an_error_and_leaves_the_frames_before(tmp_path, path):
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    whole = path.read_bytes()
    resource.setrlimit(resource.RLIMIT_FSIZE, (6000, limits[1]))  # as a disk with no more room
    try:
        with pytest.raises(OSError, match="File too large"):
            frames.append(path, 1.5, frame(3))
        with pytest.raises(OSError, match="File too large"):
            frames.create(tmp_path / "other.vtkhdf", 4, 0.0, frame(0))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert frames.times(path).tolist() == [0.0, 0.5, 1.0]
    assert all(same(frames.read(path, k), frame(k)) for k in range(3))
    assert not (tmp_path / "other.vtkhdf").exists()
    frames.cut(path, 3)
    assert path.read_bytes()[:6000] == whole[:6000]


def test_both_counts_of_frames_change_with_one_write_in_the_first_page(path):
    """VTK crashes where they differ, and a kill comes between two writes or at the edge of a page."""
    before = path.read_bytes()
    with counting(path, 2):
        pass
    after = path.read_bytes()
    changed = [k for k in range(len(before)) if before[k] != after[k]]
    with h5py.File(path) as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == len(file["VTKHDF/Steps/Values"]) == 2
    assert sum(k < 4096 for k in changed) >= 2
    with counting(path, 3):
        pass
    for k in range(4096):
        assert path.read_bytes()[k] == before[k]


def test_can_be_read_while_another_has_it_open(path):
    with h5py.File(path):
        frames.append(path, 1.5, frame(3))
    assert len(frames.times(path)) == 4


def test_a_kill_at_any_moment_leaves_a_whole_file(tmp_path):
    path = tmp_path / "gas.vtkhdf"
    frames.create(path, 3000, 0.0, frame(0))
    generator = np.random.default_rng(5)
    for _ in range(20):
        count = len(frames.times(path))
        with killed_at_last(append_frames, path, count):
            clock.sleep(0.002 + 0.02 * generator.random())
        times = frames.times(path)
        assert np.array_equal(times, 0.5 * np.arange(len(times)))
        with h5py.File(path) as file:
            assert file["VTKHDF/Steps"].attrs["NSteps"] == len(times)
        assert all(same(frames.read(path, k), frame(k)) for k in range(max(count - 1, len(times) - 5), len(times)))
        frames.cut(path, len(times))
    assert len(times) > 1


TRIANGLES = np.random.default_rng(9).permuted(np.tile(np.arange(POINTS), (45, 1)), axis=1)[:, :3]


@pytest.fixture
def membrane(tmp_path):
    path = tmp_path / "zona.vtkhdf"
    frames.create(path, 2, 0.0, frame(0), Cells(triangles=TRIANGLES))
    return path


def test_the_cells_of_a_membrane_are_its_triangles(membrane, path):
    assert np.array_equal(frames.read_cells(membrane).triangles, TRIANGLES)
    assert np.array_equal(frames.read_cells(path).points, np.arange(POINTS)[:, None])
    assert frames.read_cells(path).surface().shape == (0, 3)
    with h5py.File(membrane) as file:
        assert file["VTKHDF/Polygons/NumberOfCells"][0] == len(TRIANGLES)
        assert file["VTKHDF/Vertices/NumberOfCells"][0] == 0


def test_a_membrane_keeps_its_triangles_when_its_file_grows_or_is_cut(membrane):
    for k in (1, 2, 3, 4):
        frames.append(membrane, 0.5 * k, frame(k))
    frames.cut(membrane, 4)
    assert np.array_equal(frames.read_cells(membrane).triangles, TRIANGLES)
    assert all(same(frames.read(membrane, k), frame(k)) for k in range(4))


def opened_in_vtk(path):
    """VTK's own reader of the file."""
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader


@pytest.mark.vtk
@pytest.mark.parametrize("count", [1, 3])
def test_vtk_reads_a_membrane_as_a_surface(membrane, count):
    pytest.importorskip("vtk")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    for k in range(1, count):
        frames.append(membrane, 0.5 * k, frame(k))
    reader = opened_in_vtk(membrane)
    assert reader.GetNumberOfSteps() == count
    for k in range(count):
        reader.SetStep(k)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfVerts() == 0
        assert np.array_equal(vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3), TRIANGLES)
        assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), frame(k)["position"])
        assert np.array_equal(vtk_to_numpy(data.GetPointData().GetArray("density")), frame(k)["density"])


def corners(seed: int, cells: int, each: int) -> np.ndarray:
    return np.random.default_rng(seed).permuted(np.tile(np.arange(POINTS), (cells, 1)), axis=1)[:, :each]


QUADS = corners(8, 31, 4)
MIXED = Cells(corners(1, 7, 1), corners(2, 5, 2), TRIANGLES, QUADS)
BODIES = {
    "quads": Cells(quadrilaterals=QUADS),
    "both": Cells(quadrilaterals=QUADS, triangles=TRIANGLES),
    "triangles": Cells(triangles=TRIANGLES),
    "lines": Cells(lines=MIXED.lines),
    "mixed": MIXED,
    "solid": Cells(tetrahedra=corners(3, 12, 4)),
    "all": MIXED._replace(tetrahedra=corners(3, 12, 4)),
}


@pytest.fixture(params=BODIES)
def body(tmp_path, request):
    path = tmp_path / "bag.vtkhdf"
    frames.create(path, 2, 0.0, frame(0), BODIES[request.param])
    return path, BODIES[request.param]


def test_cells_come_back_and_stay_when_the_file_grows(body):
    path, cells = body
    for k in (1, 2, 3):
        frames.append(path, 0.5 * k, frame(k))
    found = frames.read_cells(path)
    for kind in Cells._fields:
        assert np.array_equal(getattr(found, kind), getattr(cells, kind)), kind
    assert same(frames.read(path, 3), frame(3))


@pytest.mark.vtk
def test_vtk_reads_every_kind_of_cell(body):
    pytest.importorskip("vtk")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    path, cells = body
    for k in (1, 2):
        frames.append(path, 0.5 * k, frame(k))
    reader = opened_in_vtk(path)
    assert reader.GetNumberOfSteps() == 3
    reader.SetStep(2)
    reader.Update()
    data = reader.GetOutput()
    solid = len(cells.tetrahedra) > 0
    assert data.GetClassName() == ("vtkUnstructuredGrid" if solid else "vtkPolyData")
    kinds = {1: "points", 3: "lines", 5: "triangles", 9: "quadrilaterals", 10: "tetrahedra"}
    found = {kind: [] for kind in Cells._fields}
    for index in range(data.GetNumberOfCells()):
        cell = data.GetCell(index)
        found[kinds[cell.GetCellType()]].append([cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())])
    assert found == {kind: getattr(cells, kind).tolist() for kind in Cells._fields}
    assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), frame(2)["position"])
    assert np.array_equal(vtk_to_numpy(data.GetPointData().GetArray("density")), frame(2)["density"])


@pytest.mark.vtk
@pytest.mark.parametrize("count", [1, 2, 3])
def test_vtk_reads_it(tmp_path, count):
    pytest.importorskip("vtk")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    path = tmp_path / "gas.vtkhdf"
    frames.create(path, 7, 0.0, frame(0))
    for k in range(1, count):
        frames.append(path, 0.5 * k, frame(k))
    reader = opened_in_vtk(path)
    assert reader.GetNumberOfSteps() == count
    for k in range(count):
        reader.SetStep(k)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfVerts() == POINTS
        assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), frame(k)["position"])
        for name, values in frame(k).items():
            stored = vtk_to_numpy(data.GetPointData().GetArray(name))
            assert np.array_equal(stored, values[:, frames.TO_VTK] if name == "stress" else values)
