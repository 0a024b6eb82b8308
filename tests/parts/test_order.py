"""Users' loads, probes and initial fields see the points of every body in the order of its mesh, surface or seeding.

In a velocity field with others and in one of its own, before and after sortings and in a run that goes on.
"""

from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from elements import element_sheet
from membranes import sheet
from registries import forgotten_afterwards
from small_cases import GAS, advance, box, case

from pellucid.bodies.meshless_solid.functions import quadrature_places
from pellucid.bodies.models import BODIES
from pellucid.case import Case
from pellucid.case.probe import quantity, reduction
from pellucid.extend import InitialField, Load, PointsView, Vector, parameter, register
from pellucid.parts.families import GridBody
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.start import _in_order
from pellucid.simulation.simulation import Simulation

SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e3, "poisson_ratio": 0.3}
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.45}
LIPID = {"kind": "lipid-film", "density": 100.0, "viscosity": 0.1, "stiffness": 400.0}
MARKED = {"initial": [{"kind": "marked"}]}
BLOCK = box((-0.5, -0.25, -0.25), (0.5, 0.5, 0.25)) | MARKED
BALL = {"surface": {"sphere": {"centre": (0.0, 0.0, 0.0), "radius": 0.4, "divisions": 4}}}
MESH = {"box": {"lower": (-0.5, -0.25, -0.25), "upper": (0.5, 0.5, 0.25), "cells": (4, 3, 2)}}
SAMPLES = {
    "solid": BLOCK,
    "fluid": BLOCK | {"material": GAS | {"density": 1000.0, "pressure": 1.0}},
    "rigid": BLOCK | {"rigid": True},
    "membrane-points": sheet(points=(13, 13), material=SKIN) | MARKED,
    "membrane-elements": element_sheet(points=(7, 7), material=SKIN) | MARKED,
    "meshless-solid": {"kind": "meshless-solid", "mesh": MESH, "material": TISSUE} | MARKED,
    "fluid-film": {"kind": "fluid-film", "shape": BALL, "material": LIPID, "drag": {"normal": 50.0, "tangential": 50.0}},
}
KINDS = [(name, alone) for name in SAMPLES for alone in (False, True) if (name, alone) != ("meshless-solid", False)]
every_body = pytest.mark.parametrize(("name", "alone"), KINDS, ids=[f"{name}{'-alone' * alone}" for name, alone in KINDS])
RIGHT = {"box": {"lower": (0.1, -3.0, -3.0), "upper": (3.0, 3.0, 3.0)}}
FORCE, DT = (2.0, -1.0, 3.0), 0.009
seen: list[tuple[np.ndarray, np.ndarray]] = []
asked: list[np.ndarray] = []


def mark(n: int) -> np.ndarray:
    """A velocity of its own for each of n points."""
    k = np.arange(n)
    return np.array((1.2, -0.6, 0.4)) + 1e-3 * np.stack([np.sin(k), np.cos(2 * k), np.sin(3 * k)], axis=1)


@pytest.fixture(autouse=True, scope="module")
def users_kinds():
    with forgotten_afterwards():

        @register
        class Shove(Load):
            """A force shared by the points that were on the right at first, by their places in the arrays."""

            kind: Literal["shove"] = "shove"
            force: Vector = parameter("N", "force")

            def forces(self, points: PointsView, time: float) -> np.ndarray:
                seen.append((points.id.copy(), points.position.copy()))
                right = seen[0][1][:, 0] > 0.1
                return np.where(right[:, None], np.array(self.force) / right.sum(), 0.0)

        @register
        class Press(Load):
            kind: Literal["press"] = "press"

            def forces(self, points: PointsView, time: float) -> np.ndarray:
                return 3.0 * points.vector_area

        @register
        class Marked(InitialField):
            kind: Literal["marked"] = "marked"

            def at(self, position: np.ndarray) -> np.ndarray:
                asked.append(position.copy())
                return mark(len(position))

        @quantity("doubled", unit="m", meaning="twice the place", components=3)
        def doubled(field):
            assert np.array_equal(field("id"), np.arange(len(field("id"))))
            return 2.0 * field("position")

        @reduction("eleventh")
        def eleventh(values):
            return values[10]

        yield


PROBES = [
    {"name": name, "body": "it", "quantity": quantity, "component": "x", "reduce": reduce}
    for name, quantity, reduce in (
        ("own", "doubled", "eleventh"),
        ("plain", "position", "eleventh"),
        ("mean", "doubled", "mean"),
    )
]


def build(name: str, alone: bool, **more) -> Simulation:
    seen.clear()
    asked.clear()
    table = SAMPLES[name] | {"name": "it", "field": "own" if alone else "common"}
    if name == "fluid-film" and not alone:
        table = {key: value for key, value in table.items() if key != "drag"} | MARKED
    far = box((-1.75, -1.75, -1.5), (-1.25, -1.25, -1.0), GAS, per_cell=(1, 1, 1), name="far")
    grid = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
    others = [] if (name, alone) == ("fluid-film", True) else [far]  # a film by itself has no inertia for contact
    return Simulation(case(table, *others, **grid, step=DT, end=10.0, probe=PROBES, energy={"stop": 1.0}, **more), threads=1)


def shoved(name: str, alone: bool) -> Simulation:
    return build(name, alone, load=[{"kind": "shove", "body": "it", "force": FORCE}])


def test_every_kind_is_among_them() -> None:
    kinds = {kind for kind, model in BODIES.entries.items() if model.__module__.startswith("pellucid.") and model.moves}
    assert {table.get("kind", "material-points") for table in SAMPLES.values()} == kinds


@every_body
def test_what_users_see_is_in_the_order_of_the_body(name: str, alone: bool) -> None:
    half = 1 if (name, alone) == ("fluid-film", True) else 10  # of the steps; a film takes many of its own
    sim = shoved(name, alone)
    body = sim.bodies[0]
    n, start = body.n_points, body.arrays["position"][body.order()].copy()
    model = sim.case.body[0]
    if name == "meshless-solid":
        assert np.array_equal(start, model.mesh.mesh().nodes)
    elif name.startswith("membrane"):
        assert np.array_equal(start, model.surface.triangulate().vertices)
    elif name == "fluid-film":
        assert start == pytest.approx(model.shape.surface.triangulate().vertices, abs=0.2), "nodes of Loop's surfaces are near"
    else:
        assert np.array_equal(start, model.seeded(sim.case.grid).position)
    if "initial" in model.model_fields_set:
        assert np.array_equal(asked[-1], start)
        if name == "fluid-film":  # the forecast asks at the vertices, as it has no nodes yet
            assert all(places == pytest.approx(start, abs=0.2) for places in asked)
        else:
            assert all(np.array_equal(places, start) for places in asked)
        if name != "rigid":
            assert np.array_equal(body.arrays["velocity"][body.order()], mark(n))

    (first, before) = seen[0]
    assert np.array_equal(first, np.arange(n))
    assert np.array_equal(before, start)
    stored = body.arrays["id"].copy()
    advance(sim, half)
    if isinstance(body, GridBody):
        body.storage.sort()
        assert not np.array_equal(body.arrays["id"], stored)
    advance(sim, half)
    whole = [position for _, position in seen[-2 * half :]]
    spacing = np.sort(np.linalg.norm(start[:, None] - start[None], axis=2), axis=1)[:, 1].min()
    for earlier, later in pairwise(whole):
        assert np.linalg.norm(later - earlier, axis=1).max() < 0.5 * spacing, "each is the one that it was a step before"
    frame = body.frame()
    assert np.array_equal(frame["id"], np.arange(n))
    for field in body.field_names:
        assert np.array_equal(body.field(field), frame[field]), field
    own, plain, mean = ProbeReader(sim.case.probe).read(sim.bodies, {}, sim.time)
    x = frame["position"][:, 0]
    assert (own, plain, mean) == pytest.approx((2.0 * x[10], x[10], 2.0 * x.mean()), rel=1e-13)

    # the same force on the same points, by a region
    load = {"kind": "point-load", "body": "it", "where": RIGHT, "force": FORCE}
    other = advance(build(name, alone, load=[load]), 2 * half)
    exact = 1e-9 if (name, alone) == ("fluid-film", True) else 1e-12  # its balance is solved by iteration
    assert other.bodies[0].frame()["position"] == pytest.approx(frame["position"], abs=exact)
    assert other.budget.energies()["load_work"] == pytest.approx(sim.budget.energies()["load_work"], rel=1e-9)

    # in two parts
    half_way = advance(shoved(name, alone), half)
    arrays, numbers = {key: array.copy() for key, array in half_way.state_arrays().items()}, half_way.state_numbers()
    late = shoved(name, alone)
    late.restore(arrays, numbers)
    if isinstance(late.bodies[0], GridBody):
        late.bodies[0].storage.sort()
    advance(late, half)
    again = [position for _, position in seen[-half:]]
    assert all(np.array_equal(one, other) for one, other in zip(whole[half:], again, strict=True))
    assert np.array_equal(late.bodies[0].frame()["position"], frame["position"])


MEMBRANES = [(name, alone) for name, alone in KINDS if name.startswith("membrane") or name == "fluid-film"]


@pytest.mark.parametrize(("name", "alone"), MEMBRANES, ids=[f"{name}{'-alone' * alone}" for name, alone in MEMBRANES])
def test_membranes_show_normals_areas_and_triangles(name: str, alone: bool) -> None:
    """In the same order: a user's pressure is that of the package."""
    sims = [build(name, alone, **acting) for acting in ({"load": [{"kind": "press", "body": "it"}]}, {"pressure": [PRESSURE]})]
    n_steps = 1 if name == "fluid-film" and alone else 5  # a film by itself asks for pressures within its own steps
    first, second = (advance(sim, n_steps).bodies[0].frame()["position"] for sim in sims)
    assert first == pytest.approx(second, abs=1e-12 if n_steps > 1 else 1e-4)
    body = sims[0].bodies[0]
    points = PointsView(body)
    a, b, c = points.position[points.triangles.T]
    across = 0.5 * np.cross(b - a, c - a)
    curved = 0.06 if name == "fluid-film" else 1e-6  # between the nodes of a film it bends; quadrilaterals are warped
    assert points.area.sum() == pytest.approx(np.linalg.norm(across, axis=1).sum(), rel=curved)
    assert points.vector_area.sum(axis=0) == pytest.approx(across.sum(axis=0), abs=1e-7 if name == "fluid-film" else 1e-12)
    assert np.linalg.norm(points.normal, axis=1) == pytest.approx(1.0, rel=1e-12)
    thirds = np.zeros_like(points.position)
    for corner in points.triangles.T:
        np.add.at(thirds, corner, across / 3.0)
    along = np.einsum("pi,pi->p", thirds, points.normal) / np.linalg.norm(thirds, axis=1)
    assert along.min() > 0.95, "normals are those of the triangles about each point"
    assert not points.normal.flags.writeable


PRESSURE = {"body": "it", "value": 3.0}


def test_other_bodies_have_no_normals() -> None:
    points = PointsView(build("solid", False).bodies[0])
    for name in ("normal", "area", "triangles", "vector_area"):
        with pytest.raises(ValueError, match="body it is not a membrane: it has no"):
            getattr(points, name)
    with pytest.raises(AttributeError, match=r"has no `normals`; available: id, position, .*\n    did you mean `normal`\?"):
        points.normals  # noqa: B018


def test_a_stress_at_the_start_is_asked_at_the_points_of_the_mesh_as_it_is_given() -> None:
    """Cell after cell, though the body works on cells in another order."""
    with forgotten_afterwards():

        @register
        class Numbered(InitialField):
            kind: Literal["numbered"] = "numbered"
            quantity = "stress"

            def at(self, position: np.ndarray) -> np.ndarray:
                asked.append(position.copy())
                return np.arange(len(position))[:, None] * np.ones(6)

        asked.clear()
        table = SAMPLES["meshless-solid"] | {"name": "it", "initial": [{"kind": "numbered"}]}
        model = case(table, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0)).body[0]
        mesh, ordered = model.mesh.mesh(), model.mesh_in_order()
        places = quadrature_places(ordered, model.points_per_cell)
        stress = model.initial_stress_at(places)
    assert np.array_equal(asked[0], quadrature_places(mesh, model.points_per_cell))
    assert not np.array_equal(asked[0], places)
    assert np.array_equal(asked[0][stress[:, 0].astype(int)], places)


def test_a_field_of_a_user_is_asked_at_the_points_alone_where_solids_touch() -> None:
    """Their surfaces have points of their own, which move as the material points next to them."""
    other = box((0.6, -0.25, -0.25), (1.1, 0.5, 0.25), name="other", field="other")
    contact = [{"between": ["it", "other"], "kind": "frictionless"}]
    asked.clear()
    grid = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
    sim = Simulation(case(SAMPLES["rigid"] | {"name": "it"}, other, **grid, contact=contact), threads=1)
    body = sim.bodies[0]
    assert body.contact_surface is not None
    assert [len(position) for position in asked] == [body.n_points]
    assert body.contact_surface.velocity == pytest.approx(
        np.tile((1.2, -0.6, 0.4), (len(body.contact_surface.velocity), 1)), abs=3e-3
    )


def test_the_concentration_at_the_start_is_asked_in_the_order_of_the_surface() -> None:
    with forgotten_afterwards():

        @register
        class Spot(InitialField):
            kind: Literal["spot"] = "spot"
            quantity = "concentration"

            def at(self, position: np.ndarray) -> np.ndarray:
                asked.append(position.copy())
                return np.arange(len(position))

        asked.clear()
        domain = {"surface": {"icosphere": {"centre": (0.0, 0.0, 0.0), "radius": 1.0, "refinements": 2}}}
        body = {"kind": "diffusing-field", "name": "it", "material": {"diffusivity": 1.0}}
        table = body | {"domain": domain, "initial": [{"kind": "spot"}]}
        probes = [{"name": "tenth", "body": "it", "quantity": "concentration", "reduce": "eleventh"}]
        whole = {"schema": 1, "title": "a spot", "time": {"end": 1.0, "step": 0.1}, "body": [table], "probe": probes}
        sim = Simulation(Case.model_validate(whole), threads=1)
        body = sim.bodies[0]
        assert np.array_equal(asked[0], body.frame()["position"])
        assert np.array_equal(body.field("concentration"), np.arange(body.n_points))
        assert ProbeReader(sim.case.probe).read(sim.bodies, {}, 0.0) == [10.0]


@pytest.mark.parametrize("alone", [False, True])
def test_a_film_goes_on_from_an_earlier_run_in_the_order_of_its_surface(alone: bool) -> None:
    """States of earlier runs come in the order of the numbers of the points, and the film computes in another."""
    earlier = advance(build("fluid-film", alone, load=[{"kind": "shove", "body": "it", "force": FORCE}]), 2).bodies[0]
    film = build("fluid-film", alone).bodies[0]
    assert not np.array_equal(earlier.arrays["id"], np.arange(earlier.n_points))
    film.load_state(_in_order(earlier.state_arrays()))
    for name, values in earlier.frame().items():
        assert np.array_equal(film.frame()[name], values), name
