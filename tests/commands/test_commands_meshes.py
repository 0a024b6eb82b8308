"""`pellucid mesh`: what it prints, writes and draws, and its exit status."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.geometry.files.writing import write_surface
from pellucid.geometry.surfaces.file import SurfaceFile
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface

CUBE = BoxSurface(lower=(0, 0, 0), upper=(1, 1, 1), points=(3, 3, 3)).mesh()


@pytest.fixture
def turned(tmp_path: Path) -> Path:
    """A cube with one element turned."""
    quads = CUBE.quads.copy()
    quads[3] = quads[3][::-1]
    write_surface(tmp_path / "cube.obj", ".obj", CUBE.vertices, quads, CUBE.triangles)
    return tmp_path / "cube.obj"


def invoke(*words: object):
    return CliRunner().invoke(app, ["mesh", *map(str, words)])


def test_faults_are_printed_with_status_2_and_the_repair_ends_well(turned: Path) -> None:
    result = invoke(turned)
    assert result.exit_code == 2
    assert "fault: neighbouring quadrilaterals have opposite normals at 4 edges" in result.output
    result = invoke(turned, "--repair")
    assert result.exit_code == 0
    assert "note: 1 element was reversed to match its neighbours" in result.output
    assert result.output.rstrip().endswith("no faults remain")


def test_a_mended_file_is_written_in_the_unit_of_the_first(turned: Path, tmp_path: Path) -> None:
    result = invoke(turned, "--repair", "--unit", "mm", "--out", tmp_path / "new.ply")
    assert result.exit_code == 0
    assert "0.001 x 0.001 x 0.001 m" in result.output
    assert np.array_equal(SurfaceFile(path=str(tmp_path / "new.ply")).mesh().vertices, CUBE.vertices)
    assert invoke(tmp_path / "new.ply").exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cube.obj", "new.ply"]


def test_the_file_itself_is_never_written_over(turned: Path, tmp_path: Path) -> None:
    before = turned.read_bytes()
    (tmp_path / "link.obj").symlink_to(turned)
    for name in (turned, tmp_path / "link.obj"):
        result = invoke(turned, "--repair", "--out", name)
        assert result.exit_code == 2
        assert "is the input file, which is never overwritten" in result.output
    assert turned.read_bytes() == before


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--close-holes", "3"], "--close-holes has an effect only with --repair.\n    Add --repair."),
        (["--unit", "kg"], "--unit kg: "),
        (["--out", "new.step"], "a surface cannot be written to a file with the ending .step\n    use one of .stl"),
        (["--out", "nowhere/new.stl"], "cannot be written: the folder"),
        (["--picture", "cube.jpg"], "only PNG files can be written"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(
    turned: Path, tmp_path: Path, monkeypatch, options: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke(turned, *options)
    assert result.exit_code == 2
    assert words in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["cube.obj"]


def test_a_file_that_cannot_be_read_has_status_2(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text("a poem")
    result = invoke(tmp_path / "a.stl")
    assert result.exit_code == 2
    assert "pellucid: " in result.output
    assert "a.stl cannot be read as a mesh" in result.output
    assert "Traceback" not in result.output
    for path, reason in ((tmp_path / "b.stl", "there is no file"), (tmp_path, "is a folder, not a file")):
        result = invoke(path)
        assert result.exit_code == 2
        assert reason in result.output


def test_a_picture_shows_what_is_turned_and_where_it_is_open(turned: Path, tmp_path: Path) -> None:
    from PIL import Image

    orange, red = [], []
    write_surface(tmp_path / "open.obj", ".obj", CUBE.vertices, CUBE.quads[1:], CUBE.triangles)
    write_surface(tmp_path / "whole.obj", ".obj", *CUBE)
    for name in ("cube", "open", "whole"):
        invoke(tmp_path / f"{name}.obj", "--picture", tmp_path / f"{name}.png")
        r, g, b = np.moveaxis(np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB"), int), -1, 0)
        orange.append(int(((r > g + 40) & (g > b + 10) & (b > 20)).sum()))
        red.append(int(((r > 150) & (g < 60) & (b < 60)).sum()))
    assert orange[0] > 500
    assert red[1] > 100
    assert orange[2] == red[2] == red[0] == 0
