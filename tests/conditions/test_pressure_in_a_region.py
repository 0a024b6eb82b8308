"""Pressure on part of a membrane, as of a pipette's mouth: resultant, choice once or in each step, and what is refused."""

import numpy as np
import pytest

from pellucid.case import Case
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.simulation.simulation import Simulation

SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
SHEET = {"rectangle": {"corner": (4, 4, 8), "first_edge": (8, 0, 0), "second_edge": (0, 8, 0), "points": (17, 17)}}
MOUTH = {"cylinder": {"centre": (8.1, 8.0, 8.0), "radius": 2.2, "height": 2.0}}
ON_GRID = {"grid": {"lower": (0, 0, 0), "upper": (16, 16, 16), "cell": 1.0}}
POINTS, QUADS = {"kind": "membrane-points"}, {"kind": "membrane-elements"}
TRIANGLES = QUADS | {"elements": "triangles"}
OTHER = {
    "name": "other",
    "kind": "membrane-elements",
    "surface": {"rectangle": {"corner": (2, 2, 3), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (3, 3)}},
    "thickness": 0.01,
    "material": SKIN,
}


def made(kind, pressure, **more):
    body = {"name": "skin", "surface": SHEET, "thickness": 0.01, "material": SKIN} | kind
    bodies = [body, *more.pop("others", [])]
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": bodies, "pressure": [{"body": "skin"} | pressure]}
    return Case.model_validate(table | more)


def area_of_mouth(body, moved=(0.0, 0.0)):
    """The vector area of the faces whose centres are in the mouth [m²], shape (3,)."""
    places, triangles = body.places(), body.cells().surface()
    centre = places[triangles].mean(axis=1)
    within = np.hypot(centre[:, 0] - 8.1 - moved[0], centre[:, 1] - 8.0 - moved[1]) <= 2.2
    return vector_areas(places, triangles)[within].sum(axis=0)


def force(sim):
    """The impulse of the next step over its length [N], shape (3,)."""
    before = np.array(sim.momentum())
    sim.step()
    return (sim.momentum() - before) / sim.dt


@pytest.mark.parametrize(
    ("kind", "more"),
    [
        pytest.param(POINTS, ON_GRID, id="points"),
        pytest.param(QUADS, ON_GRID | {"others": [OTHER]}, id="quadrilaterals-on-the-grid"),
        pytest.param(TRIANGLES, {}, id="triangles-on-own-nodes"),
        pytest.param(QUADS, {}, id="quadrilaterals-on-own-nodes"),
    ],
)
@pytest.mark.parametrize("choose", ["start", "each-step"])
def test_the_resultant_is_pressure_times_the_area_in_the_region(kind, more, choose):
    sim = Simulation(made(kind, {"value": 100.0, "where": MOUTH, "choose": choose}, **more), threads=1)
    skin = sim.bodies[0]
    area = area_of_mouth(skin)
    assert area == pytest.approx([0.0, 0.0, np.pi * 2.2**2], rel=0.05, abs=1e-12)
    assert force(sim) == pytest.approx(100.0 * area, abs=1e-10 * 100.0 * area[2])
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_a_region_that_the_membrane_leaves_is_named():
    moving, mouth = TRIANGLES | {"velocity": (200.0, 0.0, 0.0)}, {"value": 1.0, "where": MOUTH, "choose": "each-step"}
    sim = Simulation(made(moving, mouth), threads=1)
    while sim.n_steps < 99:
        sim.step()
    assert 200.0 * sim.time > 2 * 2.2 + 8.0, "the sheet is beyond the mouth"
    with pytest.warns(UserWarning, match=r"`pressure\.0\.where` has no effect: no face of body `skin`.*enlarge it"):
        sim.step()


def test_a_region_in_each_step_stays_while_the_membrane_moves():
    moving = TRIANGLES | {"velocity": (40.0, 0.0, 0.0)}
    once = Simulation(made(moving, {"value": 1.0, "where": MOUTH}), threads=1)
    anew = Simulation(made(moving, {"value": 1.0, "where": MOUTH, "choose": "each-step"}), threads=1)
    while once.time < 0.03:
        once.step()
        anew.step()
    travelled = 40.0 * once.time
    skin = anew.bodies[0]
    assert travelled > 1.0
    stays, goes_along = area_of_mouth(skin), area_of_mouth(once.bodies[0], (travelled, 0.0))
    assert force(anew)[2] == pytest.approx(stays[2], rel=1e-9)
    assert force(once)[2] == pytest.approx(goes_along[2], rel=1e-9)
    centre = np.average(skin.places(), axis=0, weights=np.abs(skin.motion.loads[0, :, 2]))
    assert centre[0] == pytest.approx(8.1, abs=0.3)


def test_all_faces_of_a_region_push_as_the_whole_membrane_does():
    ball = {"surface": {"icosphere": {"centre": (8.03, 8.01, 7.98), "radius": 5.0, "refinements": 3}}}
    everywhere = {"box": {"lower": (0, 0, 0), "upper": (16, 16, 16)}}
    sims = [Simulation(made(TRIANGLES | ball, {"value": 100.0} | more), threads=1) for more in ({}, {"where": everywhere})]
    for sim in sims:
        sim.step()
    whole, region = (sim.bodies[0].motion.loads[0] for sim in sims)
    assert region == pytest.approx(whole, abs=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize(
    ("change", "more", "words"),
    [
        ({"where": {"sphere": {"centre": (8, 8, 12), "radius": 1.0}}}, {}, "no face of body skin lies in it at the start"),
        ({"where": {"set": "mouth"}}, {}, "the mesh of body skin has no named sets"),
        ({"choose": "each-step"}, {}, "`choose` belongs to `where`"),
        ({"where": MOUTH, "choose": "now"}, {}, "start.*each-step"),
        (
            {"where": MOUTH},
            {"grid": {"lower": (0, 0, 7.5), "upper": (16, 16, 8.5), "cell": 1.0}},
            "membrane in a plane problem",
        ),
    ],
)
def test_regions_that_make_no_sense(change, more, words):
    with pytest.raises(ValueError, match=words):
        made(POINTS, {"value": 100.0} | change, **(ON_GRID | more))


def test_a_set_of_a_surface_file_is_pressed_as_its_faces(tmp_path):
    meshlane = pytest.importorskip("meshlane")
    edge = np.linspace(0.0, 1.0, 7)
    points = np.array([(x, y, 0.0) for x in edge for y in edge])
    corner = np.array([7 * i + j for i in range(6) for j in range(6)])
    triangles = np.concatenate([corner[:, None] + (0, 7, 8), corner[:, None] + (0, 8, 1)])
    left = (points[:, 0] < 0.51).astype(int)
    file = tmp_path / "sheet.vtu"
    meshlane.write(str(file), meshlane.Mesh(points, [("triangle", triangles)], point_data={"left": left}))
    sheet = TRIANGLES | {"surface": {"file": {"path": str(file)}}}
    sim = Simulation(made(sheet, {"value": 10.0, "where": {"set": "left"}}), threads=1)
    assert force(sim) == pytest.approx([0.0, 0.0, 5.0], abs=1e-12)
    with pytest.raises(ValueError, match="has no set of this name; its sets are left"):
        made(sheet, {"value": 10.0, "where": {"set": "lef"}})
