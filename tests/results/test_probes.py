import numpy as np
import pytest

from pellucid.case import Probe
from pellucid.results import probes

FRAME = {
    "position": np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
    "velocity": np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0], [0.0, -2.0, 0.0]]),
    "pressure": np.array([1.0, 5.0, 3.0]),
    "stress": np.array([[7.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [4.0, 4.0, 4.0, 0.0, 0.0, 0.0]]),
}


def probe(quantity, reduce="mean", component=None, at=None):
    return Probe(name="p", body="gas", quantity=quantity, reduce=reduce, component=component, at=at)


@pytest.mark.parametrize(
    ("asked", "value"),
    [
        (probe("pressure"), 3.0),
        (probe("pressure", "max"), 5.0),
        (probe("pressure", "min"), 1.0),
        (probe("pressure", "sum"), 9.0),
        (probe("pressure", "nearest", at=(1.4, 0.3, 0.0)), 5.0),
        (probe("velocity", "min", "y"), -2.0),
        (probe("velocity", "max"), 5.0),
        (probe("stress", "max", "xy"), 2.0),
        (probe("stress", "max"), 7.0),
        (probe("stress", "nearest", at=(1.0, 0.0, 0.0)), 2.0 * np.sqrt(3.0)),
        (probe("stress", "min"), 0.0),
    ],
)
def test_reduces_a_field_to_a_number(asked, value):
    assert probes.reduce(asked, FRAME.__getitem__) == pytest.approx(value, rel=1e-15)


def test_only_the_needed_arrays_are_fetched_each_once():
    class Body:
        name = "gas"

        def __init__(self):
            self.fetched = []

        def field(self, name):
            self.fetched.append(name)
            return FRAME[name]

    body = Body()
    asked = [probe("pressure"), probe("velocity", "max"), probe("pressure", "min")]
    assert probes.evaluate(asked, [body]) == [3.0, 5.0, 1.0]
    assert body.fetched == ["pressure", "velocity"]
