import json
import math

import numpy as np
import pytest

from pellucid.results.metrics import Metric


@pytest.mark.parametrize(("error", "passed"), [(0.0, True), (0.1, True), (0.2, False), (math.nan, False), (math.inf, False)])
def test_passes_within_its_tolerance(error, passed):
    assert Metric(1.0, 1.0, error, 0.1).passed is passed


def test_becomes_json_whatever_numbers_it_holds():
    metric = Metric(np.float64(1.5), math.nan, np.float64(0.2), 0.5, "m", "a length")
    assert json.loads(json.dumps(metric.to_data(), allow_nan=False)) == {
        "value": 1.5, "reference": None, "error": 0.2, "tolerance": 0.5, "pass": True,
    }  # fmt: skip
