"""Hard bodies that are small beside the faces of a soft one are warned of, others are not."""

import warnings

import pytest

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation


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
    with pytest.warns(UserWarning, match=r"body needle, .* 1\.4 of the edges of its faces there .*; use a finer mesh there"):
        Simulation(punch(0.002, 14))


@pytest.mark.parametrize(("radius", "cells"), [(0.006, 14), (0.003, 26)])
def test_one_of_enough_edges_does_not(radius, cells):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Simulation(punch(radius, cells))
