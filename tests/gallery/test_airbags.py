"""What the airbag's metrics measure, on states that are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.case import load
from pellucid.gallery.lian2014 import airbags

CASE = load("lian2014/airbag")
BAG = CASE.body[2].surface.triangulate()


class Still:
    """A run that shows the bag of the start, with some points of gas."""

    case = SimpleNamespace(grid=CASE.grid, body=CASE.body)

    def __init__(self, gas=(), stress=None):
        self.gas, self.stress = np.array(gas).reshape(-1, 3), stress

    def times(self, body):
        return np.zeros(1)

    def triangles(self, body):
        return BAG.triangles

    def fields(self, body, time=None):
        if body == "bag":
            return {"position": BAG.vertices, "stress": self.stress}
        n = len(self.gas)
        weight = np.ones(n) if body == "charge" else np.full(n, 3.0)
        return {"position": self.gas, "mass": weight, "density": np.ones(n), "pressure": weight}


def test_volume_is_that_of_the_whole_bag():
    # 4/9 of sides and height; the facets of 24 squares to a half are within the curved sheet
    assert airbags.bag_volume(Still(), 0.0) == pytest.approx(4.0 / 9.0 * 0.1, rel=2e-3)


def test_mean_pressure_weighs_volumes():
    assert airbags.gas_pressure(Still([(0.1, 0.1, 0.01)]), 0.0) == pytest.approx((1.0 * 1.0 + 3.0 * 3.0) / 4.0)


@pytest.mark.parametrize(("z", "share"), [(0.04, 0.0), (0.053, 0.0), (0.06, 0.5)])
def test_a_point_leaks_a_quarter_of_a_cell_outside(z, share):
    assert airbags._outside(Still([(0.1, 0.1, 0.01), (0.01, 0.01, z)]), 0.0) == share


def test_principal_stresses_of_any_frame():
    one = np.array([[3.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 0.0]])
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turned = turn @ one @ turn.T
    stress = turned[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    assert airbags._extreme_stresses(Still(stress=np.tile(stress, (4, 1))), 0.0) == pytest.approx((-2.0, 3.0))


@pytest.mark.parametrize(
    "settings",
    [
        {"body.bag.surface.cushion.height": 0.08, "body.air.shape.cushion.height": 0.08},
        {"body.bag.material.poisson_ratio": 0.4},
    ],
)
def test_another_bag_has_no_reference(settings):
    run = Still()
    run.case = load("lian2014/airbag").with_settings(settings)
    with pytest.raises(ValueError, match="gallery's cushion"):
        airbags.cushion_metrics(run)
