"""Hard bodies that are small beside the faces of a soft one, and drops in another liquid with few cells in their radius, are
warned of; others are not."""

import pytest
from small_cases import box, case

from pellucid.case import Case
from pellucid.set_up.coarse_bodies import coarse_drops, coarse_indenters


def punch(radius: float, cells: int) -> Case:
    """A punch over a block of soft tissue of 20 mm, with so many cells across."""
    mesh = {"box": {"lower": [-0.01, -0.01, 0], "upper": [0.01, 0.01, 0.006], "cells": [cells, cells, 3]}}
    elastic = {"kind": "linear-elastic", "density": 7800, "young_modulus": 1e9, "poisson_ratio": 0.3}
    soft = {"kind": "neo-hookean", "density": 1050, "young_modulus": 1e4, "poisson_ratio": 0.3}
    cylinder = {"centre": [0, 0, 0.009], "radius": radius, "height": 0.004}
    return Case.model_validate(
        {
            "schema": 1,
            "title": "a punch",
            "grid": {"lower": [-0.012, -0.012, 0], "upper": [0.012, 0.012, 0.014], "cell": 0.001},
            "time": {"end": 1e-3},
            "body": [
                {"name": "tissue", "kind": "meshless-solid", "field": "tissue", "mesh": mesh, "material": soft},
                {
                    "name": "needle",
                    "kind": "material-points",
                    "field": "needle",
                    "shape": {"cylinder": cylinder},
                    "material": elastic,
                },
            ],
            "motion": [
                {
                    "name": "push",
                    "body": "needle",
                    "hold": ["x", "y"],
                    "displacement": {"z": {"kind": "ramp", "distance": -1e-3, "duration": 1e-3}},
                }
            ],
        }
    )


def test_a_punch_of_few_edges_warns():
    (text,) = coarse_indenters(punch(0.002, 14))
    assert "the non-deforming body needle has a radius of 0.002 m where it can touch body tissue" in text
    assert "1.4 mesh edges of 0.00143 m, fewer than 3" in text
    assert text.endswith("Use a finer mesh of body tissue near this place.")


@pytest.mark.parametrize(("radius", "cells"), [(0.006, 14), (0.003, 26)])
def test_one_of_enough_edges_does_not(radius, cells):
    assert list(coarse_indenters(punch(radius, cells))) == []


def test_a_quarter_of_a_punch_counts_with_its_images():
    quarter = punch(0.002, 14).to_data()
    quarter["grid"]["lower"][:2] = [0, 0]
    quarter["body"][0]["mesh"]["box"] |= {"lower": [0, 0, 0], "cells": [7, 7, 3]}
    quarter["body"][1]["cut_at"] = ["x-lower", "y-lower"]
    quarter["support"] = [{"where": face, "fix": "normal"} for face in ("x-lower", "y-lower")]
    assert list(coarse_indenters(Case.model_validate(quarter))) == list(coarse_indenters(punch(0.002, 14)))


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
