"""Given volumes of membranes: through limit points, in balance, and what is refused."""

import numpy as np
import pytest
from bags import case, skin

from pellucid.geometry.meshes.enclosure import enclosed_volume
from pellucid.results.storage import history
from pellucid.running.launch import resume_case, run_case
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

G, THICKNESS = 1e5, 0.01
RUBBER = {"kind": "neo-hookean-membrane", "density": 1000.0, "young_modulus": 2.998 * G, "poisson_ratio": 0.499}
TWICE = {"times": [0, 0.2], "ratios": [1, 1.5]}


def given(volume=TWICE, bodies=None, **more):
    return case(bodies=bodies or [skin()], pressure=[{"body": "skin", "volume": volume} | more.pop("pressure", {})], **more)


def test_a_rubber_ball_passes_its_limit_point_by_its_volume():
    """p R/(G h) = 2 (1/λ - 1/λ⁷) of an incompressible neo-Hookean sheet, at most 1.23946 at λ = 7^(1/6) = 1.3831."""
    end = 8.0
    ball = skin(material=RUBBER, thickness=THICKNESS)
    sim = Simulation(given({"times": [0, end], "ratios": [1, 4.1]}, [ball], end=end), threads=1)
    start, area = sim.parts.columns()["skin_volume"], sim.bodies[0].surface_areas().sum()
    radius = 3.0 * start / area  # that of the ball which the facets touch
    curve = []
    for _ in sim:
        now = sim.parts.columns()
        curve.append(((now["skin_volume"] / start) ** (1.0 / 3.0), now["skin_pressure"] * radius / (G * THICKNESS)))
    stretch, pressure = np.array(curve).T
    wanted = 2.0 * (1.0 / stretch - stretch**-7.0)
    assert stretch[-1] > 1.58
    assert pressure[stretch > 1.1] == pytest.approx(wanted[stretch > 1.1], rel=0.005)
    assert pressure.max() == pytest.approx(1.23946, rel=0.002)
    assert stretch[np.argmax(pressure)] == pytest.approx(7.0 ** (1.0 / 6.0), abs=0.03)
    assert pressure[-1] < 1.19
    assert np.abs(np.diff(pressure)).max() < 0.05, "it passes without a jump"
    assert abs(sim.budget.conservation()["energy"]) < 1e-4
    places = sim.bodies[0].places()
    assert sim.parts.columns()["skin_volume"] == pytest.approx(
        enclosed_volume(places, sim.bodies[0].cells().surface()), rel=1e-12
    )


def test_a_flat_disc_is_blown_up_from_nothing_along_its_normal():
    disc = {"disc": {"centre": (0, 0, 0), "normal": (0, 0, 1), "radius": 1.0, "rings": 6}}
    rim = {"body": "skin", "where": "boundary", "fix": ["x", "y", "z"]}
    volume = {"times": [0, 1.5], "volumes": [0, "0.4 m^3"]}
    blown = given(volume, [skin(disc)], pressure={"lids": True}, support=[rim], end=2.0)
    sim = Simulation(blown, threads=1)
    for _ in sim:
        pass
    now = sim.parts.columns()
    assert now["skin_volume"] == pytest.approx(0.4, rel=0.05)
    assert now["skin_pressure"] > 0.0
    # a paraboloid holds π h/2
    assert sim.bodies[0].places()[:, 2].max() == pytest.approx(0.8 / np.pi, rel=0.1)


def test_a_stiff_spring_bounds_the_step_and_is_stable():
    cases = [given(pressure=more) for more in ({}, {"stiffness": 1e8})]
    soft, stiff = (Simulation(each, threads=1) for each in cases)
    for each, sim in zip(cases, (soft, stiff), strict=True):
        assert of_case(each).step == pytest.approx(0.9 * sim.step_limit()[0].step, rel=0.01), "it is foretold"
    assert soft.step_limit()[0].cause == "membrane"
    limit, _ = stiff.step_limit()
    assert limit.cause == "spring"
    assert "oscillates on its given volume" in limit.reason
    wanted, start = TWICE["ratios"], stiff.parts.columns()["skin_volume"]
    for _ in stiff:
        volume = start * np.interp(stiff.time, TWICE["times"], wanted)
        assert stiff.parts.columns()["skin_volume"] == pytest.approx(volume, rel=2e-3)
    assert abs(stiff.budget.conservation()["energy"]) < 0.02


def test_runs_with_given_volumes_go_on_bit_for_bit(tmp_path):
    output = {"output": {"history": 0.01, "frames": 0.1}}
    run_case(given(**output), tmp_path / "whole", threads=1, report=False)
    run_case(given(**output), tmp_path / "two", threads=2, until=0.09, report=False)
    resume_case(tmp_path / "two", threads=2, report=False)
    first, second = ((tmp_path / name / "history.csv").read_bytes() for name in ("whole", "two"))
    assert first == second
    columns = history.read(tmp_path / "whole" / "history.csv")
    assert columns["skin_volume"][-1] / columns["skin_volume"][0] == pytest.approx(1.5, rel=0.1)
    assert columns["skin_pressure"].max() > 100.0


def test_a_volume_may_stand_in_a_file(tmp_path):
    file = tmp_path / "volume.csv"
    file.write_text("time,volume\n0,4.05\n0.2,6\n")
    found = given({"path": str(file)}).pressure[0].volume
    assert found.at(0.1, 9.0)[0] == pytest.approx(5.025)
    assert found.at(1.0, 9.0) == (6.0, 0.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"value": 100.0}, "both `value` and `volume`; give one of the two"),
        ({"volume": None}, "neither `value` nor `volume`"),
        ({"volume": None, "value": 1.0, "stiffness": 1e3}, "`stiffness` belongs to `volume`"),
        ({"rise": 0.1}, "`rise` belongs to `value`"),
        ({"where": {"sphere": {"centre": (0, 0, 0), "radius": 1.0}}}, "`where` belongs to `value`"),
        ({"stiffness": 0.0}, "stiffness"),
        ({"lids": True}, "is closed: it has no rim"),
        ({"volume": {"times": [0, 1], "volumes": [1.0, 2.0]}}, "its pressure would jump"),
        ({"volume": {"times": [0, 1], "volumes": [1.0, 2.0], "ratios": [1, 2]}}, "either `times` with `volumes` or `ratios`"),
        ({"volume": {"times": [0, 1], "ratios": [1, 2, 3]}}, "2 times and 3 volumes"),
        ({"volume": {"times": [0, 0], "ratios": [1, 2]}}, "does not come after"),
        ({"volume": {"times": [0, 1], "ratios": [1, -2]}}, "volume cannot be negative"),
        ({"volume": {"times": [0, 1], "ratios": [1, 0]}}, "give ratios above 0"),
    ],
)
def test_given_volumes_that_make_no_sense(change, words):
    table = {"body": "skin", "volume": TWICE} | change
    with pytest.raises(ValueError, match=words):
        case(pressure=[{key: value for key, value in table.items() if value is not None}])


def test_a_membrane_has_one_given_volume_and_no_steady_states():
    with pytest.raises(ValueError, match=r"`pressure.0` already has history columns with these names"):
        case(pressure=[{"body": "skin", "volume": TWICE}] * 2)
    with pytest.raises(ValueError, match="cannot find the equilibrium of a membrane with a prescribed volume"):
        given(steady={"method": "relaxation"})
