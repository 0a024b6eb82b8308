"""Loads: forces that a model gives, checked and handed to bodies."""

from typing import ClassVar, Literal

import numpy as np
import pytest
from registries import forgotten_afterwards
from small_cases import advance, box, simulation
from solids import block

from pellucid.conditions.loads.contract import Load, PointsView, checked_forces
from pellucid.conditions.loads.forces import BodyForce
from pellucid.energy import FIRST_LOAD, Channel, WorkLayout
from pellucid.errors import CaseError, RunStopped
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.registry import register
from pellucid.simulation.simulation import Simulation


class Body:
    """Takes down what it is pushed with."""

    def __init__(self, name="block", n=5):
        self.name = name
        shapes = {"position": (n, 3), "velocity": (n, 3), "mass": (n,), "volume": (n,)}
        random = np.random.default_rng(0)
        self.arrays = {key: random.random(shape) for key, shape in shapes.items()}
        self.arrays["id"] = np.arange(n)
        self.n_points = n
        self.is_surface = False
        self.forces: dict[int, np.ndarray] = {}

    def order(self):
        return slice(None)

    def volumes(self):
        return self.arrays["volume"]

    def add_external_force(self, force, column):
        self.forces[column] = self.forces.get(column, 0.0) + force


def test_what_a_load_sees_of_the_points():
    body = Body()
    points = PointsView(body)
    for name in ("id", "position", "velocity", "mass", "volume"):
        seen = getattr(points, name)
        assert np.shares_memory(seen, body.arrays[name])
        with pytest.raises(ValueError, match="read-only"):
            seen += 1
        assert body.arrays[name].flags.writeable


def begin(bodies, loads, time):
    """Let loads act on bodies over the step that begins at a time."""
    layout = WorkLayout(Channel(load.channel) for load in loads)
    assembly = Assembly({body.name: AssembledBody(body, None, None) for body in bodies}, (), layout)
    for kind in dict.fromkeys(type(load) for load in loads):
        for part in kind.activate([load for load in loads if type(load) is kind], assembly):
            part.try_out()
            part.begin(time, 0.1)


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
        begin([body], [load], time)
        assert np.array_equal(body.forces[FIRST_LOAD], body.arrays["mass"][:, None] * share * np.array([0.0, 2.0, 0.0]))
    sudden = load.model_copy(update={"rise": 0.0})
    begin([body], [sudden], 0.0)
    assert body.forces[FIRST_LOAD][:, 1].sum() == pytest.approx(4.0 * body.arrays["mass"].sum())


def test_loads_push_their_own_body_and_book_in_their_own_column():
    one, two = Body("one"), Body("two")
    loads = [BodyForce(body="two", acceleration=(1, 0, 0)), Spring(body="one"), BodyForce(body="one", acceleration=(1, 0, 0))]
    begin([one, two], loads, 2.0)
    assert set(two.forces) == {FIRST_LOAD}
    assert np.array_equal(one.forces[FIRST_LOAD + 1], -2.0 * one.arrays["position"])
    assert np.array_equal(one.forces[FIRST_LOAD][:, 0], one.arrays["mass"])


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        (
            np.zeros(3),
            r'"strange" on body block returns no forces: `forces` returns an array of shape \(3,\); .* shape \(5, 3\)',
        ),
        (None, r"`forces` returns None; it must return an array of shape \(5, 3\), see .*test_loads.py:\d+"),
        ("much", r"`forces` returns a str; it must return an array"),
        ([[1.0], [1.0, 2.0]], r"`forces` returns a list of rows of different lengths; it must return an array"),
        (
            np.full((5, 3), np.nan),
            r'"strange" on body block returns the force \[nan nan nan\] N at t = 0.2 s .* correct its `forces`',
        ),
    ],
)
def test_forces_that_are_none_stop_the_run(forces, words):
    class Strange(Load):
        kind: Literal["strange"] = "strange"

        def forces(self, points: PointsView, time: float) -> np.ndarray:
            return forces

    with pytest.raises(RunStopped, match=words):
        checked_forces(Strange(body="block"), PointsView(Body()), 0.2)
    with pytest.raises(CaseError, match="`forces`") as refused:  # before anything is written
        begin([Body()], [Strange(body="block")], 0.2)
    assert refused.value.problems[0].key == "load.0"


def pushed(load, time):
    """The forces of a load on a body at a time [N]."""
    body = Body()
    begin([body], [load], time)
    return body.forces[FIRST_LOAD]


def test_a_load_of_a_user_rises_and_has_an_amplitude_without_a_word_in_it():
    whole, body = Spring(body="block"), Body()
    assert np.array_equal(pushed(whole, 0.25), -0.25 * body.arrays["position"])
    assert np.array_equal(pushed(Spring(body="block", rise=0.5), 0.25), -0.125 * body.arrays["position"])
    falling = {"times": (0.0, 1.0), "shares": (1.0, 0.0)}
    assert np.array_equal(pushed(Spring(body="block", amplitude=falling), 0.25), -0.75 * 0.25 * body.arrays["position"])
    with pytest.raises(ValueError, match="`rise` and `amplitude` cannot be combined"):
        Spring(body="block", rise=0.5, amplitude=falling)


def test_keys_that_a_load_declares_itself_are_its_own():
    class Swinging(Load):
        kind: Literal["swinging"] = "swinging"
        amplitude: float = 2.0
        where: str = "somewhere"

        def forces(self, points: PointsView, time: float) -> np.ndarray:
            return self.amplitude * np.ones_like(points.position)

    assert (pushed(Swinging(body="block"), 0.25) == 2.0).all()
    assert (pushed(Swinging(body="block", rise=0.5), 0.25) == 1.0).all()


RIGHT = {"box": {"lower": (2.0, 0.0, 0.0), "upper": (4.0, 4.0, 4.0)}}


def test_a_load_of_a_user_acts_where_it_is_told():
    """On points that the grid has sorted, as the load of the package on the same region."""
    with forgotten_afterwards():

        @register
        class Even(Load):
            kind: Literal["even"] = "even"

            def forces(self, points: PointsView, time: float) -> np.ndarray:
                return np.full_like(points.position, 1.0 / 32.0)

        loads = {"kind": "even", "where": RIGHT}, {"kind": "point-load", "where": RIGHT, "force": (1.0, 1.0, 1.0)}
        one, other = (
            advance(simulation(box((1, 1, 1), (3, 3, 3)), step=2e-3, load=[load | {"body": "block"}]), 5) for load in loads
        )
        far = {"box": {"lower": (3.5, 0.0, 0.0), "upper": (4.0, 4.0, 4.0)}}
        with pytest.raises(CaseError, match="where") as refused:
            simulation(box((1, 1, 1), (3, 3, 3)), load=[{"kind": "even", "body": "block", "where": far}])
    assert refused.value.problems[0].key == "load.0.where"
    assert np.array_equal(one.bodies[0].frame()["velocity"], other.bodies[0].frame()["velocity"])
    assert one.budget.energies()["load_work"] == other.budget.energies()["load_work"] > 0.0


def test_loads_are_tried_when_all_bodies_are_complete():
    """A solid on its own nodes has its masses only then."""
    with forgotten_afterwards():

        @register
        class Weighed(Load):
            kind: Literal["weighed"] = "weighed"

            def forces(self, points: PointsView, time: float) -> np.ndarray:
                return points.mass[:, None] / points.mass.sum() * np.ones(3)

        sim = Simulation(block(load=[{"kind": "weighed", "body": "block", "rise": 0.0}]))
        advance(sim, 2)
    assert sim.momentum() == pytest.approx(np.full(3, sim.time), rel=1e-12)


@pytest.mark.parametrize("name", ["gravity_work", "spring_energy"])
def test_a_channel_is_a_work_of_its_own(name):
    with pytest.raises(
        TypeError, match=rf'Spring\.channel = "{name}" must end in "_work" and be none of gravity_work, support_work'
    ):
        type("Spring", (Load,), {"__annotations__": {"channel": ClassVar[str]}, "channel": name, "__module__": __name__})


SHEET = {
    "name": "block",
    "surface": {"rectangle": {"corner": (1.1, 1.1, 2.3), "first_edge": (2, 0, 0), "second_edge": (0, 2, 0), "points": (9, 9)}},
    "thickness": 0.01,
    "material": {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3},
}


@pytest.mark.parametrize(
    "body",
    [box((1, 1, 1), (3, 3, 3)), SHEET | {"kind": "membrane-points"}, SHEET | {"kind": "membrane-elements"}],
    ids=["material-points", "membrane-points", "membrane-elements"],
)
def test_a_body_force_on_all_is_gravity(body):
    """The same motion, booked as work and impulse of the load."""
    pull = (0.3, 0.0, -2.0)
    falling = advance(simulation(body, step=2e-3, gravity=pull), 5)
    load = {"kind": "body-force", "body": "block", "acceleration": pull}
    pushed = advance(simulation(body, step=2e-3, load=[load]), 5)
    for name in ("position", "velocity"):
        assert np.allclose(falling.bodies[0].arrays[name], pushed.bodies[0].arrays[name], rtol=0.0, atol=1e-14)
    assert pushed.momentum() == pytest.approx(0.01 * falling.bodies[0].mass * np.array(pull), rel=1e-12, abs=1e-12)
    assert pushed.budget.energies()["load_work"] == pytest.approx(falling.budget.energies()["gravity_work"], rel=1e-12)
    assert abs(pushed.budget.conservation()["momentum"]) < 1e-12
    assert abs(pushed.budget.conservation()["energy"]) < 1e-12
