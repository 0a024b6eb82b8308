"""Triangles that are strained from their rest shape: folded flat, turned over, and back."""

import numpy as np
import pytest
from elements import body_of, bring, distorted, element_sheet, forces, global_stress, places, rotation, step
from membranes import E

from pellucid.errors import RunStopped
from pellucid.geometry.surfaces.surface import Surface

every_law = pytest.mark.parametrize("law", ["linear-membrane", "neo-hookean-membrane"])
SHEET = {"rectangle": {"corner": (-0.49, -0.48, 0.03), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (7, 7)}}


def tension_field(law):
    """A distorted sheet of triangles that bear no compression."""
    return distorted_sheet(law, wrinkling=True)


def distorted_sheet(law, wrinkling):
    table = element_sheet(law)
    table["material"]["wrinkling"] = wrinkling
    return body_of(table, distorted(Surface.model_validate(SHEET).mesh("triangles"), 0.05))


def pinched(start, stretch, width):
    """Pulled along x, and its width changed: below zero the sheet lies on its other side."""
    return start * (stretch, width, 1.0)


@every_law
def test_a_strip_that_is_pinched_to_less_than_nothing_keeps_its_tension_and_its_step(law):
    body = tension_field(law)
    start = places(body)
    bring(body, pinched(start, 1.02, 0.5))
    rate, energy, tension = body.totals.rate, body.totals.stored, forces(body)
    for width in (0.1, 1e-3, 1e-6, 0.0, -1e-6, -0.1, -0.5):
        bring(body, pinched(start, 1.02, width))
        # the fastest eigenfrequency is that of the smooth strip, however narrow its outline
        assert body.totals.rate == pytest.approx(rate, rel=1e-6), width
        assert body.totals.stored == pytest.approx(energy, rel=1e-9)
        # NARROWEST: rounding of the stress across, 1e-16, is seen through (1e3)²
        assert np.abs(forces(body) - tension).max() < 1e-9 * np.abs(tension).max()
    assert np.abs(tension[:, 1:]).max() < 1e-9 * np.abs(tension).max()


@every_law
def test_a_slack_sheet_is_turned_over_at_no_cost_and_is_what_it_was(law):
    body = tension_field(law)
    start = places(body)
    bring(body, pinched(start, 1.02, 1.01))
    stress, energy = global_stress(body), body.totals.stored
    generator = np.random.default_rng(3)
    bring(body, 0.9 * start)
    slack = body.totals.stored
    for _ in range(5):
        bring(body, 0.6 * start @ rotation(generator.normal(size=3), 1.0).T + generator.uniform(-0.005, 0.005, start.shape))
        assert np.abs(forces(body)).max() == 0.0
        assert body.totals.stored == slack
    bring(body, 0.9 * start)
    bring(body, pinched(start, 1.02, 1.01))
    assert global_stress(body) == pytest.approx(stress, abs=1e-12 * E)
    # the two ways through the pull are trapezoids of one step over the same kinks
    assert body.totals.stored == pytest.approx(energy, rel=0.05)


@every_law
def test_what_bears_compression_must_not_turn_over(law):
    body = body_of(element_sheet(law, elements="triangles"))
    with pytest.raises(RunStopped, match="element at this node turned over"):
        bring(body, pinched(places(body), 1.0, -0.5))


@every_law
def test_no_history_is_left_behind(law):
    """To and fro through any strains: the stress is that of the place alone, to rounding."""
    body = distorted_sheet(law, wrinkling=False)
    start, generator = places(body), np.random.default_rng(5)
    target = start @ np.array([[1.05, 0.02, 0.0], [-0.01, 0.97, 0.0], [0.0, 0.0, 1.0]]).T
    bring(body, target)
    stress = global_stress(body)
    for _ in range(20):
        bring(body, target + generator.uniform(-0.02, 0.02, start.shape))
    bring(body, target)
    assert global_stress(body) == pytest.approx(stress, abs=1e-13 * E)


@every_law
def test_a_crumpling_sheet_keeps_its_energy(law):
    """Thrown together at random in space: what it loses in motion it stores, at steps that do not shrink."""
    body = tension_field(law)
    generator = np.random.default_rng(1)
    sound = np.sqrt(E / 1000.0)
    body.arrays["velocity"][:] = 0.05 * sound * generator.normal(size=(49, 3))
    body.renew_totals()
    energy, rate = body.totals.kinetic, body.totals.rate
    worst, fastest = 0.0, 0.0
    for _ in range(2000):
        step(body, 0.1 / rate)
        worst = max(worst, abs(body.totals.kinetic + body.totals.stored - energy))
        fastest = max(fastest, body.totals.rate)
    # the works and energies of a step lie half a step apart: 0.5 %, and half of it with half the step
    assert worst < 0.01 * energy
    assert fastest < 1.1 * rate
    assert body.totals.stored > -1e-3 * energy
