"""The cubic between two equilibria on a path, and its limit points."""

import numpy as np
import pytest

from pellucid.simulation.path_search import PathPoint, Span


def between(factors, rates):
    """Return the span of the length 1 of a straight path, with these load factors and rates at both ends."""
    ends = zip((0.0, 1.0), factors, rates, strict=True)
    along = np.array([[1.0, 0.0, 0.0]])
    return Span(*(PathPoint(place * along, factor, along, rate) for place, factor, rate in ends))


@pytest.mark.parametrize(
    ("factors", "rates", "kinds"),
    [
        ((0.0, 0.1), (1.0, -1.0), ["maximum"]),
        ((0.0, 2.0), (1.0, -1.0), ["maximum"]),
        ((0.0, 0.1), (-1.0, 1.0), ["minimum"]),
        ((0.0, 0.0), (1.0, 1.0), ["maximum", "minimum"]),
        ((0.0, 0.0), (-1.0, -1.0), ["minimum", "maximum"]),
        ((0.0, 1.0), (1.0, 1.0), []),
        ((1.0, 1.0 + 1e-8), (1e-7, 1e-7), []),
    ],
)
def test_the_signs_of_the_rates_decide_on_limit_points(factors, rates, kinds):
    """Two between equal signs count if their load factors differ by more than the tolerance."""
    span = between(factors, rates)
    found = span.limits(1e-6)
    assert [kind for kind, _ in found] == kinds
    nearby = np.array([-0.01, 0.0, 0.01])
    for kind, share in found:
        values = [span.factor(share + step) for step in nearby]
        assert np.argmax(values if kind == "maximum" else np.negative(values)) == 1


def test_the_cubic_between_equilibria_finds_limit_points_and_values():
    """On a circle through the origin with the load factor sin s at the distance s."""

    def at(s):
        turned = np.array([[np.sin(s), 1.0 - np.cos(s), 0.0]])
        return PathPoint(turned, float(np.sin(s)), np.array([[np.cos(s), np.sin(s), 0.0]]), float(np.cos(s)))

    span = Span(at(1.3), at(1.8))
    assert span.length == pytest.approx(0.5, rel=0.5**4 / 100.0)
    (share,) = span.extremes()
    assert 1.3 + 0.5 * share == pytest.approx(np.pi / 2.0, abs=1e-3)
    assert span.factor(share) == pytest.approx(1.0, abs=0.5**4 / 300.0)
    assert span.first_at(0.99) == pytest.approx((np.arcsin(0.99) - 1.3) / 0.5, abs=1e-2)
    assert span.first_at(1.01) is None
    assert abs(span.position(0.5) - at(1.55).position).max() < 0.5**4 / 300.0
