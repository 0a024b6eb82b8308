"""Steady states with approximate factors, those of linear tetrahedra, for solids whose own factors are too large: here for
small ones, with a lower limit."""

import numpy as np
import pytest
from small_cases import to_the_end
from solids import EDGE, TISSUE, block_of, displacement, layer

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.bodies.meshless_solid import model
from pellucid.case import Case, steady
from pellucid.case.sections import parts_of
from pellucid.parts.elastic_system import LARGEST_FACTORS
from pellucid.running.launch import resume_case, run_case
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

LOW, HIGH = {"name": "bottom", "where": layer(0.0)}, layer(EDGE)
LED = {"name": "top", "body": "block", "part": HIGH}
RAMPS = {axis: {"kind": "steady", "velocity": v} for axis, v in (("x", 0), ("y", 0.01), ("z", 0.03))}
STRETCHED = LED | {"displacement": RAMPS}


def block(body=None, settings=None, **more):
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": settings or {}, "support": [LOW]}
    own = block_of(cells=(3, 3, 3)) | (body or {})
    return Case.model_validate(table | {"body": [own], "motion": [STRETCHED]} | more)


def approximate(monkeypatch):
    """Let all solids have approximate factors."""
    monkeypatch.setattr(model, "LARGEST_FACTORS", 0.0)
    monkeypatch.setattr(model, "FEW_NODES", 0.0)


@pytest.fixture
def none_is_small(monkeypatch):
    approximate(monkeypatch)
    monkeypatch.setattr(steady, "FEW_NODES", 0.0)


def facts(simulation):
    return simulation.facts()["steady"]


def compared(monkeypatch, **given):
    """Return a case, finished with its own factors and with approximate ones."""
    own = to_the_end(block(**given))
    approximate(monkeypatch)
    return own, to_the_end(block(**given))


@pytest.mark.parametrize("averaged", [False, True])
@pytest.mark.parametrize("approximant", NODAL_APPROXIMANTS.entries)
def test_equilibria_and_works_are_those_with_the_own_factors(approximant, averaged, monkeypatch):
    body = {"approximant": {"kind": approximant}, "volume_averaging": averaged}
    own, found = compared(monkeypatch, body=body, settings={"load_steps": 2, "tolerance": 1e-7})
    assert abs(displacement(found) - displacement(own)).max() < 1e-6 * abs(displacement(own)).max()
    assert found.budget.stored == pytest.approx(own.budget.stored, rel=1e-10)
    assert facts(found)["relaxed_load_steps"] == []
    assert found.budget.energy_error() == pytest.approx(own.budget.energy_error(), abs=2e-4), "the tangents have an error"
    if approximant != "linear-simplex":
        assert facts(found)["lowest_frequencies"] == [None, None], "they are not those of the tetrahedra"


@pytest.mark.parametrize("approximant", NODAL_APPROXIMANTS.entries)
def test_few_iterations_are_needed(approximant, none_is_small):
    """Also where nodal values are far from the values of the field at the nodes, as with maximum entropy: without this, it
    needs four times as many."""
    found = to_the_end(block(body={"approximant": {"kind": approximant}, "volume_averaging": False}))
    assert facts(found)["steps"][0] < 100


def test_nearly_incompressible_solids(monkeypatch):
    own, found = compared(monkeypatch, body={"material": TISSUE | {"poisson_ratio": 0.49}})
    assert abs(displacement(found) - displacement(own)).max() < 1e-6 * abs(displacement(own)).max()
    assert facts(found)["steps"][0] < 150


def test_loads_that_follow(monkeypatch):
    pressure = {"body": "block", "value": 400.0, "where": {"normal": [0, 0, 1]}}
    own, found = compared(monkeypatch, motion=[], pressure=[pressure], settings={"load_steps": 2})
    assert abs(displacement(found) - displacement(own)).max() < 1e-6 * abs(displacement(own)).max()
    assert abs(found.budget.energy_error()) < 1.1 * abs(own.budget.energy_error())


def test_a_body_without_supports_does_not_drift(monkeypatch):
    load = [
        {"kind": "traction", "where": {"normal": [way, 0, 0]}, "body": "block", "traction": [200.0 * way, 0.0, 0.0]}
        for way in (1, -1)
    ]
    own, found = compared(monkeypatch, motion=[], support=[], load=load)
    assert abs(displacement(found) - displacement(own)).max() < 1e-6 * abs(displacement(own)).max()


def test_results_do_not_depend_on_threads(none_is_small):
    one, two = (displacement(to_the_end(block(), threads)) for threads in (1, 2))
    assert (one == two).all()


def test_a_run_goes_on_bit_for_bit(tmp_path, none_is_small):
    case = block(settings={"load_steps": 3})
    run_case(case, tmp_path / "whole", report=False)
    run_case(case, tmp_path / "part", report=False, until=0.5)
    resume_case(tmp_path / "part", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("part", "whole"))
    assert one == other


# which factors


def cube(cells, upper=(1, 1, 1), **more):
    body = {"mesh": {"box": {"lower": [0, 0, 0], "upper": upper, "cells": cells}}}
    return block(body=body, motion=[], **more)


def is_factored(case):
    return case.steady.is_factored(parts_of(case))


def test_slender_bodies_of_many_nodes_have_their_own_factors():
    slender, compact = cube([200, 7, 7], (200, 7, 7)), cube([22, 22, 22])
    assert slender.body[0].n_points(None) > 20_000
    assert not slender.body[0].approximates_stiffness
    assert slender.body[0].stiffness_size().numbers < LARGEST_FACTORS
    assert compact.body[0].approximates_stiffness
    assert is_factored(slender)
    assert is_factored(compact)


def test_the_size_of_approximate_factors_is_told(none_is_small):
    why = of_case(cube([3, 3, 3])).why
    assert "with a factored stiffness of 273 unknowns" in why
    assert "(factors of the linear tetrahedra of the mesh, an approximation, since those of the solid are too large: " in why


def test_factors_that_are_too_large_are_not_used(none_is_small, monkeypatch):
    monkeypatch.setattr(steady, "LARGEST_APPROXIMATE", 0.0)
    assert not is_factored(cube([3, 3, 3]))


def test_solids_that_are_too_stiff_against_changes_of_volume_are_relaxed(none_is_small):
    """With a bulk modulus of 5000 times the shear modulus, 400 iterations are not enough."""
    stiff, less = (block(body={"material": TISSUE | {"poisson_ratio": ratio}}) for ratio in (0.4999, 0.499))
    assert is_factored(less)
    reason = steady.why_not_factored(parts_of(stiff))
    assert reason is not None
    assert "nearly incompressible" in reason


def test_contact_and_implicit_steps_need_the_own_factors(none_is_small):
    grid = {"lower": [-1, -1, -1], "upper": [1, 1, 1], "cell": 0.02}
    wall = {"point": [0, 0, -0.01], "normal": [0, 0, 1]}
    assert is_factored(block(grid=grid))
    touching = block(grid=grid, wall=[wall])
    reason = "contact needs the factors of the stiffness itself, and those of body block are too large"
    assert steady.why_not_factored(parts_of(touching)) == reason
    assert not is_factored(touching)
    assert of_case(touching).why.endswith(f"They are relaxed because {reason}")
    reason = "implicit steps need the factors of the stiffness itself, and those of body block are too large"
    assert steady.why_not_implicit(parts_of(block())) == reason


def test_the_stiffness_of_the_tetrahedra_is_that_of_linear_functions(monkeypatch):
    """For linear functions on the tetrahedra both matrices are the same."""
    from pellucid.bodies.meshless_solid.linear_stiffness import LinearStiffness, LinearTetrahedra
    from pellucid.bodies.meshless_solid.stiffness import SolidStiffness

    for averaged in (False, True):
        case = block(body={"approximant": {"kind": "linear-simplex"}, "volume_averaging": averaged})
        body = Simulation(case, threads=1).bodies[0]
        moved = 0.02 * EDGE * np.random.default_rng(1).standard_normal(body.mesh.nodes.shape)
        body._forces.find(moved, body.motion.internal, 0.0)
        tetrahedra = LinearTetrahedra(body.mesh, body._functions.at_nodes)
        both = SolidStiffness(body._forces.solid, body.mesh.nodes), LinearStiffness(body._forces.solid, tetrahedra, abs)
        for matrix in both:
            matrix._find(0.0)
        assert np.array_equal(both[0]._indices, both[1]._indices)
        one, other = (matrix._values for matrix in both)
        assert abs(one - other).max() < 1e-12 * abs(one).max()
