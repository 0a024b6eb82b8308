from math import sqrt

import pytest

from pellucid.references.indentation import Layer, at_contact, force


def hertz(young_modulus: float, poisson_ratio: float, radius: float, depth: float) -> float:
    """Force [N] on a rigid sphere of a radius [m] that is a depth [m] in a half-space.

    Source: K. L. Johnson, Contact Mechanics, 1985, eq. 4.23.
    """
    return 4.0 / 3.0 * young_modulus / (1.0 - poisson_ratio**2) * sqrt(radius * depth**3)


@pytest.mark.parametrize("bonded", [True, False])
def test_a_thick_layer_is_hertz_half_space(bonded: bool) -> None:
    layer = Layer(3000.0, 0.3, 1e3, bonded)
    depth, push = at_contact(layer, radius=1.0, contact=0.1)
    assert depth == pytest.approx(0.01, rel=1e-3)
    assert push == pytest.approx(hertz(3000.0, 0.3, 1.0, depth), rel=1e-3)


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5])
def test_an_incompressible_bonded_layer_is_as_published(ratio: float) -> None:
    # P. D. Garcia & R. Garcia, Biophys. J. 114 (2018) 2923-2932: a series in √(Rδ)/h
    radius, thickness = 2.0, 0.5
    depth = (ratio * thickness) ** 2 / radius
    series = 1.0 + 1.133 * ratio + 1.497 * ratio**2 + 1.469 * ratio**3 + 0.755 * ratio**4
    push = force(Layer(1.0, 0.5, thickness, True), radius, depth)
    assert push / hertz(1.0, 0.5, radius, depth) == pytest.approx(series, rel=0.01)


@pytest.mark.parametrize(("bonded", "over_hertz"), [(True, 1.0445), (False, 1.0384)])
def test_finite_elements_agree(bonded: bool, over_hertz: float) -> None:
    # validation/sphere-on-layer/indentation.csv: finite strain and a finite width differ by 1.2 % from this theory
    push = force(Layer(1.0, 0.3, 4.0, bonded), radius=1.0, depth=0.02)
    assert push / hertz(1.0, 0.3, 1.0, 0.02) == pytest.approx(over_hertz, rel=0.015)


def test_a_contact_much_wider_than_the_layer_is_refused() -> None:
    with pytest.raises(ValueError, match="twice the thickness"):
        at_contact(Layer(1.0, 0.3, 0.01, True), radius=1.0, contact=0.1)
