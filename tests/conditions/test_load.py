"""Loads: forces that a model gives, checked and handed to bodies."""

from typing import ClassVar, Literal

import numpy as np
import pytest

from pellucid.conditions.load import BodyForce, Load, LoadsAtWork, PointsView
from pellucid.errors import RunStopped


class Body:
    """Takes down what it is pushed with."""

    def __init__(self, name="block", n=5):
        self.name = name
        shapes = {"position": (n, 3), "velocity": (n, 3), "mass": (n,), "volume": (n,)}
        random = np.random.default_rng(0)
        self.arrays = {key: random.random(shape) for key, shape in shapes.items()}
        self.forces: dict[int, np.ndarray] = {}

    def add_external_force(self, force, column):
        self.forces[column] = self.forces.get(column, 0.0) + force


class Spring(Load):
    kind: Literal["spring"] = "spring"
    channel = "spring_work"

    def forces(self, points: PointsView, time: float) -> np.ndarray:
        return -time * points.position


def test_a_body_force_pushes_every_mass_and_rises_smoothly():
    body = Body()
    load = BodyForce(body="block", acceleration=(0.0, 2.0, 0.0), rise=0.5)
    for time, share in ((0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (3.0, 1.0)):
        body.forces.clear()
        LoadsAtWork([body], [load], {"load_work": 7}).begin(time)
        assert np.array_equal(body.forces[7], body.arrays["mass"][:, None] * share * np.array([0.0, 2.0, 0.0]))
    sudden = load.model_copy(update={"rise": 0.0})
    LoadsAtWork([body], [sudden], {"load_work": 7}).begin(0.0)
    assert body.forces[7][:, 1].sum() == pytest.approx(4.0 * body.arrays["mass"].sum())


def test_loads_push_their_own_body_and_book_in_their_own_column():
    one, two = Body("one"), Body("two")
    loads = [BodyForce(body="two", acceleration=(1, 0, 0)), Spring(body="one"), BodyForce(body="one", acceleration=(1, 0, 0))]
    LoadsAtWork([one, two], loads, {"load_work": 7, "spring_work": 8}).begin(2.0)
    assert set(two.forces) == {7}
    assert np.array_equal(one.forces[8], -2.0 * one.arrays["position"])
    assert np.array_equal(one.forces[7][:, 0], one.arrays["mass"])


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        (np.zeros(3), r'the load of kind "strange" on body block gives forces of shape \(3,\) for 5 points; .* shape \(5, 3\)'),
        (np.full((5, 3), np.nan), r'"strange" on body block gives the force \[nan nan nan\] N; mend its `forces`'),
    ],
)
def test_forces_that_are_none_stop_the_run(forces, words):
    class Strange(Load):
        kind: Literal["strange"] = "strange"

        def forces(self, points: PointsView, time: float) -> np.ndarray:
            return forces

    with pytest.raises(RunStopped, match=words):
        LoadsAtWork([Body()], [Strange(body="block")], {"load_work": 7}).begin(0.0)


@pytest.mark.parametrize("name", ["gravity_work", "spring_energy"])
def test_a_channel_is_a_work_of_its_own(name):
    with pytest.raises(
        TypeError, match=rf'Spring\.channel = "{name}" must end in "_work" and be none of gravity_work, support_work'
    ):
        type("Spring", (Load,), {"__annotations__": {"channel": ClassVar[str]}, "channel": name, "__module__": __name__})
