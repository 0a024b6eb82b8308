import pytest

from pellucid.references.finite_elements import read
from pellucid.references.solids import BONDED_CUBE, stretched

VOLUME, AREA, SIDE = 1e-3, 1e-2, 0.1


@pytest.mark.parametrize(("form", "moved"), BONDED_CUBE)
def test_plates_that_hold_stiffen_a_little(form: str, moved: float) -> None:
    free = stretched("coupled" if form == "coupled" else "decoupled", 3000.0, 0.49, 1.0 + moved / SIDE)
    held = BONDED_CUBE[form, moved]
    assert free.energy * VOLUME < held.energy < 1.3 * free.energy * VOLUME  # less freedom, more energy: a bound
    assert abs(free.stress * AREA) < abs(held.reaction) < 1.3 * abs(free.stress * AREA)


def test_the_sides_meet_the_plate_and_draw_in_half_way_up() -> None:
    table = read("cube_bulge")
    for form in ("coupled", "decoupled"):
        free = SIDE / 2 * (stretched("coupled" if form == "coupled" else "decoupled", 3000.0, 0.49, 1.5).lateral - 1.0)
        for column in ("face_x", "edge_x"):
            across = table[f"{form}_{column}"]
            assert across[0] == 0.0
            assert free * 1.25 < across[-1] < free  # over the free block's: the middle is narrower, to conserve volume
        assert table[f"{form}_face_z"][-1] == pytest.approx(0.025, abs=1e-9)  # half-way up, by symmetry
