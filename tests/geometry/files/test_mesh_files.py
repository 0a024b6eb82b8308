"""How long the unit of a file is."""

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.geometry.surfaces.file import SurfaceFile

TRIANGLE = "v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n"


@pytest.fixture
def path(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE)
    return str(tmp_path / "a.obj")


@pytest.mark.parametrize(
    ("unit", "metres"), [("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("m", 1.0), ("nm", 1e-9), ("inch", 0.0254)]
)
def test_a_unit_is_so_many_metres(path, unit, metres):
    mesh = SurfaceFile(path=path, unit=unit, offset=(1, 0, 0)).mesh()
    assert mesh.vertices[1] == pytest.approx((1.0 + 2.0 * metres, 0.0, 0.0), rel=1e-15)


def test_unit_and_scale_are_not_given_together(path):
    with pytest.raises(
        ValidationError, match=r"`unit` and `scale` both define the unit .*: mm and 0.001 m; remove `unit` or `scale`"
    ):
        SurfaceFile(path=path, unit="mm", scale=0.001)


@pytest.mark.parametrize(("unit", "why"), [("kg", "kg"), ("furlogn", "furlogn"), ("", "unit")])
def test_what_is_no_unit_of_length_is_refused(path, unit, why):
    with pytest.raises(ValidationError, match=why):
        SurfaceFile(path=path, unit=unit)


def test_holes_are_closed_by_the_repair_alone(path):
    with pytest.raises(ValidationError, match="`close_holes` is given without `repair`; set `repair = true`"):
        SurfaceFile(path=path, close_holes=3)


def test_surfaces_need_no_extra(path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "meshlane", None)
    assert np.array_equal(SurfaceFile(path=path, scale=7.0).mesh().vertices[1], (14, 0, 0))
