"""What bodies say of themselves in the summary."""

import pytest
from meshes import irregular
from solids import held, solid

from pellucid.results.storage.recorder import facts_of


def named(name):
    return solid(irregular(2, 3), held(lambda x: x[:, 2] == 0.0), kind="linear-simplex", name=name)


def test_facts_of_several_bodies_name_the_body():
    alone = facts_of([named("one"), solid(irregular(2, 3), kind="linear-simplex")])
    assert alone == {"ebc_residual_nodes": 0.0, "ebc_residual_between": 0.0}, "where nothing is prescribed nothing can fail"
    both = facts_of([named("one"), named("two")])
    assert list(both) == [f"ebc_residual_{what} {name}" for name in ("one", "two") for what in ("nodes", "between")]


def test_a_number_that_is_not_finite_is_null():
    body = named("one")
    body.arrays["position"][:] = float("nan")
    assert facts_of([body])["ebc_residual_nodes"] is None


def test_the_residual_is_the_distance_from_what_is_prescribed():
    body = named("one")
    body.arrays["position"][body.mesh.nodes[:, 2] == 0.0] += (3e-3, 0.0, 4e-3)
    assert facts_of([body])["ebc_residual_nodes"] == pytest.approx(5e-3, rel=1e-12)
    assert facts_of([body])["ebc_residual_between"] == pytest.approx(5e-3, rel=1e-12)
