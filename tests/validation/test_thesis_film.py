"""The scheme of Benet 2015, an extension under validation: where it works, and where it fails as the thesis says."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from films import PRESSURE, case, ran
from registries import forgotten_afterwards

from pellucid.errors import CaseError, RunStopped
from pellucid.simulation.simulation import Simulation
from pellucid.users.users_code import load_file

DRIVEN = PRESSURE.format(value=0.1, on="present-area") + "along = [0, -1, 0]\n"
EXTENSION = Path(__file__).parents[2] / "validation" / "benet2015-thesis-scheme" / "thesis_film.py"


@pytest.fixture(autouse=True)
def _known():
    with forgotten_afterwards():
        load_file(str(EXTENSION))
        yield


def thesis(accuracy):
    return f"accuracy = {accuracy}"


def test_a_compressed_vesicle_grows_to_first_order_in_the_step():
    """R = 2 - exp(-t/η) at ρ = 2/R; η = 3."""
    errors = []
    for accuracy in (2e-2, 1e-2, 5e-3):
        simulation, film = ran(case(end=2.0, more=f"{thesis(accuracy)}\ndensity = 2", kind="thesis-film"))
        radii = film.field("distance")
        errors.append(float(abs(radii.mean() - (2.0 - np.exp(-2.0 / 3.0)))))
        assert np.ptp(radii) < 1e-9, "it stays a circle"
        assert abs(simulation.budget.conservation()["mass"]) < 1e-13
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)
    assert errors[2] < 2e-3


def test_an_inflated_vesicle_grows_as_it_must():
    film = ran(case(end=10.0, more=thesis(6e-3), loads_of=PRESSURE.format(value=0.15, on="present-area"), kind="thesis-film"))[
        1
    ]
    assert film.field("distance") == pytest.approx(1.199028, rel=1e-3)


def rough(film):
    """Size of the waves of a normal velocity that are shorter than four nodes [m/s]."""
    normal = film.geometry.normals(film.arrays["x"])
    waves = np.fft.rfft(np.einsum("ni,ni->n", normal, film.arrays["v"]))
    return float(np.linalg.norm(waves[len(normal) // 4 :]) / len(normal))


def roughness(of, times):
    """At times [s], as far as the run comes; whether it stopped."""
    simulation = Simulation(of)
    found = []
    try:
        while not simulation.clock.finished(None):
            simulation.step()
            if any(abs(simulation.time - time) < 1e-9 for time in times):
                found.append(rough(simulation.bodies[0]))
    except RunStopped:
        return found, True
    return found, False


@pytest.mark.filterwarnings("ignore:step 1, .* energy error")
def test_a_vesicle_that_is_driven_oscillates_more_and_more():
    """Smooth at first, a million times rougher after three seconds, until the balance of energy fails; ours stays smooth."""
    shape, times = "ellipse = { radius = 1, nodes = 41 }", (0.1, 1.5, 3.0, 4.0)
    found, stopped = roughness(case(shape, 20.0, 100.0, "", thesis(6e-3), DRIVEN, kind="thesis-film"), times)
    assert stopped
    assert found[0] < 1e-12
    assert all(later > 10.0 * before for before, later in pairwise(found))
    assert found[2] > 1e6 * found[0]
    more = "drag = { normal = 1, tangential = 1 }"
    ours, stopped = roughness(case(shape, 4.0, 100.0, "", more, DRIVEN + PRESSURE.format(value=0.2, on="present-area")), times)
    assert not stopped
    assert max(ours) < 1e-12


@pytest.mark.parametrize(
    ("shape", "bending", "more", "message"),
    [
        ("spheroid = { radius = 1, nodes = 20 }", "", "", "it is for closed curves"),
        ("ellipse = { radius = 1, nodes = 20 }", "", "drag = { normal = 1, tangential = 1 }", "has no drag"),
        ("ellipse = { radius = 1, nodes = 20 }", ", bending_rigidity = 1", "", "has no bending"),
        ("ellipse = { radius = 1, nodes = 20 }", "", "volume = {}", "has no given volume"),
    ],
)
def test_what_the_thesis_did_not_have_is_refused(shape, bending, more, message):
    with pytest.raises(CaseError, match=message):
        case(shape, bending=bending, more=more, kind="thesis-film")


def test_it_holds_no_nodes():
    held = """
[[support]]
body = "film"
where = "all-nodes"
fix = ["x"]
"""
    with pytest.raises(CaseError, match="this scheme cannot hold or lead nodes"):
        ran(case(more=thesis(1e-3), loads_of=held, kind="thesis-film"))
