"""Drops in another liquid that have too few cells in their radius are warned of."""

import pytest
from small_cases import box, case

from pellucid.set_up.drops import coarse_drops

LIQUID = {
    "kind": "fluid",
    "density": 1.0,
    "viscosity": 0.005,
    "eos": {"kind": "tait", "sound_speed": 40.0, "carries_tension": True},
}


def drop_in(density, cell, centre=(0.5, 0.5, 0.0), **more):
    """A plane drop of radius 0.2 in a fluid of this density."""
    bath = box((0, 0, 0), (1, 1, cell), LIQUID | {"density": density}, (2, 2, 1), "bath", outside=["drop"])
    shape = {"sphere": {"centre": centre, "radius": 0.2}}
    cut = more.pop("cut_at", [])
    drop = {"name": "drop", "shape": shape, "cut_at": cut, "points_per_cell": (2, 2, 1), "material": LIQUID}
    n = round(1 / cell)
    tension = [{"body": "drop", "tension": 1.0}]
    return case(bath, drop, counts=(n, n, 1), cell=cell, functions="quadratic-bspline", surface_tension=tension, **more)


@pytest.mark.parametrize(("density", "cell", "warns"), [(1.0, 0.025, True), (1.0, 0.0125, False), (0.001, 0.025, False)])
def test_drops_with_few_cells_in_a_liquid(density, cell, warns):
    found = list(coarse_drops(drop_in(density, cell)))
    assert len(found) == warns
    if warns:
        assert found[0].startswith(
            "body drop has 8 cells in its radius, fewer than 12. If it oscillates in bath, it does so too slowly"
        )


def test_a_half_of_a_drop_beside_a_plane_of_symmetry_counts_whole():
    half = drop_in(1.0, 0.0125, (0.0, 0.5, 0.0), cut_at=["x-lower"], support=[{"where": "x-lower", "fix": "normal"}])
    assert not list(coarse_drops(half))
