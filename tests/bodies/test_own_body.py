"""A body of a kind that the package does not know: a lattice of nodes between springs, which solves a linear system each step.

All that it needs stands in this file: its model with one registration, and the body itself.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np
import pytest
from pydantic import ValidationError
from registries import forgotten_afterwards
from scipy.sparse import coo_array, csc_array, identity
from scipy.sparse.linalg import splu
from small_cases import RATE_SOLID, SOLID, advance, box, simulation

from pellucid.approximants import grid_functions
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.case import Case, dumps, load
from pellucid.contact.contact_body import ContactBody
from pellucid.energy import CONTACT, FIRST_LOAD, GRAVITY, INTERNAL, SUPPORT, StepWork, Totals, no_work
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box
from pellucid.grid.model import GridCase
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.model import Vector, parameter
from pellucid.parts.body import Body, NodalSupport, Placement
from pellucid.parts.body_model import BodyModel
from pellucid.parts.families import NodalBody
from pellucid.parts.part import Parts
from pellucid.registry import register
from pellucid.running.launch import resume_case, run_case

PER_SIDE = 4


class SpringLatticeCase(BodyModel):
    """A cube of nodes joined by springs along the axes, stepped by backward Euler."""

    place: ClassVar[str] = "corner"
    takes_motions: ClassVar[bool] = False
    kind: Literal["spring-lattice"] = "spring-lattice"
    corner: Vector = parameter("m", "lower corner")
    edge: float = parameter("m", "edge", gt=0)
    stiffness: float = parameter("N/m", "of each spring", gt=0)
    material: LinearElasticMaterial = parameter("", "what its density is taken from")
    velocity: Vector = parameter("m/s", "initial velocity", (0.0, 0.0, 0.0))
    initial_stretch: float = parameter("", "strain along x at the start", 0.0)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array(self.corner), np.array(self.corner) + self.edge

    def occupied(self) -> Geometry:
        return Box(lower=self.corner, upper=tuple(self.bounds()[1]))

    @property
    def probed(self) -> tuple[str, ...]:
        return "position", "velocity"

    def n_points(self, grid: GridCase | None) -> float:
        return PER_SIDE**3

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return np.tile(np.array(self.velocity), (len(position), 1))

    def owns_nodes(self, alone: bool) -> bool:
        return True

    def needs_grid(self, parts: Parts) -> bool:
        return len(parts.of(BodyModel)) > 1

    def build(self, placement: Placement) -> Body:
        return SpringLattice(self, placement)


class SpringLattice(NodalBody):
    """Nodes in the middles of equal cubes; (M + dt² K) v = M v₀ - dt K u gives their velocities without contact."""

    energy_kind = "strain"

    def __init__(self, case: SpringLatticeCase, placement: Placement) -> None:
        self.name, self._columns = case.name, FIRST_LOAD + placement.n_loads
        spacing = case.edge / PER_SIDE
        middles = (np.arange(PER_SIDE) + 0.5) * spacing
        places = np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), axis=-1).reshape(-1, 3)
        places = places[::-1] + np.array(case.corner)  # an order that is not that of the cells
        n = len(places)
        self.arrays = {
            "id": np.arange(n),
            "position": np.ascontiguousarray(places),
            "velocity": case.initial_velocity(places),
            "mass": np.full(n, case.material.density * spacing**3),
            "start": places.copy(),
        }
        self.arrays["position"][:, 0] += case.initial_stretch * (places[:, 0] - places[:, 0].mean())
        apart = np.linalg.norm(places[:, None] - places[None], axis=2)
        one, other = np.nonzero(np.abs(apart - spacing) < 1e-9 * spacing)
        off = coo_array((np.full(len(one), -case.stiffness), (one, other)), shape=(n, n))
        self._K = csc_array(off + coo_array((-off.sum(axis=1), (np.arange(n), np.arange(n))), shape=(n, n)))
        self.coupling = None
        if placement.velocity_field is not None:
            grid_case, field = placement.on_grid()
            self.functions = grid_functions(grid_case.functions, (2, 2, 2), grid_case.thin())
            a, volume = self.arrays, np.full(n, spacing**3)
            self.coupling = GridCoupling(field, self.functions, a["position"], a["velocity"], a["mass"], volume)
        self._density, self._half_width, self.totals = case.material.density, 0.5 * spacing, Totals()
        self._gravity, self._loads = np.array(placement.gravity), np.zeros((placement.n_loads, n, 3))
        self.add_supports(())
        self.let_go(())
        self.share_gravity(1.0)
        self.renew_totals()

    def _force(self) -> np.ndarray:
        return -self._K @ (self.arrays["position"] - self.arrays["start"])

    def share_gravity(self, share: float) -> None:
        self._share = share  # of the gravity that acts

    def let_go(self, supports: Collection[int]) -> None:
        self._gone = supports

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        self._supports = [(support.nodes[:, None] & np.array(support.axes), support) for support in supports]
        self._work = no_work(self._columns, len(supports))

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        raise ValueError("the model refuses motions")

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        raise ValueError("the model refuses motions")

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        self._loads[column - FIRST_LOAD] += force

    def begin(self, dt: float) -> None:
        self._loads.fill(0.0)
        if self.coupling:
            self.coupling.sort_if_needed()

    def predict(self, dt: float) -> None:
        m, v = self.arrays["mass"][:, None], self.arrays["velocity"]
        matrix = csc_array(identity(len(m)) * float(m[0, 0]) + dt * dt * self._K)
        self._before, pulls = v.copy(), [dt * m * (self._share * self._gravity), *(dt * load for load in self._loads)]
        v[:] = splu(matrix).solve(m * v + dt * self._force() + sum(pulls))
        self._impulses = {GRAVITY: pulls[0]} | {FIRST_LOAD + k: pull for k, pull in enumerate(pulls[1:])}
        self._impulses[INTERNAL] = m * (v - self._before) - sum(pulls)
        self._constrain()
        if self.coupling:
            self.coupling.scatter()  # the trial momentum itself

    def _constrain(self) -> list[np.ndarray]:
        """Give constrained nodes their velocity; the impulses that this takes."""
        impulses = []
        for number, (held, support) in enumerate(self._supports):
            before = self.arrays["velocity"].copy()
            self.arrays["velocity"][:] = np.where(held & (number not in self._gone), support.velocity, before)
            impulses.append(self.arrays["mass"][:, None] * (self.arrays["velocity"] - before))
        return impulses

    def correct(self, remap: bool) -> None:
        m, v = self.arrays["mass"][:, None], self.arrays["velocity"]
        increment = self.coupling.gather() if self.coupling else np.zeros_like(v)
        v[:] = self._before + sum(self._impulses.values()) / m + increment
        reactions = self._constrain()
        if remap and self.coupling:
            self.coupling.scatter_momentum()
        impulses = self._impulses | {CONTACT: m * increment, SUPPORT: sum(reactions, np.zeros_like(v))}
        works, mean = np.zeros(self._columns), 0.5 * (self._before + v)
        for column, impulse in impulses.items():
            works[column] = np.sum(impulse * mean)
        rows = np.array([*(reaction.sum(axis=0) for reaction in reactions), np.zeros(3)])
        other = sum((impulses[FIRST_LOAD + k].sum(axis=0) for k in range(len(self._loads))), np.zeros(3))
        self._work = StepWork(works, self._share * float(m.sum()), rows, other, {})
        self._sum()

    def update(self, dt: float) -> None:
        self.arrays["position"] += dt * self.arrays["velocity"]
        self._fault = self.coupling.check_positions() if self.coupling else None
        self._sum()

    def renew_totals(self) -> None:
        self._fault = None
        self._sum()

    def _sum(self) -> None:
        m, v, totals = self.arrays["mass"], self.arrays["velocity"], self.totals
        totals.kinetic, totals.momentum = float(self.kinetic_energies().sum()), m @ v
        totals.momentum_size = float(m @ np.linalg.norm(v, axis=1))
        totals.stored = float(-0.5 * np.sum(self._force() * (self.arrays["position"] - self.arrays["start"])))
        cells = self.coupling.velocity_field.grid.lattice.inverse_cell if self.coupling else 1.0
        totals.rate = float(np.linalg.norm(v, axis=1).max()) * cells

    def check(self, n_steps: int, time: float) -> None:
        if self._fault is not None:
            self.stop(*self._fault, n_steps, time)

    def work(self) -> StepWork:
        return self._work

    @property
    def on_grid(self) -> ContactBody | None:
        return self if self.coupling else None

    @property
    def mapped(self):
        return self.coupling.mapped

    @property
    def n_slabs(self) -> int:
        return self.coupling.n_slabs

    def half_width(self) -> tuple[float, float, float]:
        return self._half_width, 0.0, 0.0

    def state_arrays(self) -> dict[str, np.ndarray]:
        index = self.coupling.state_arrays() if self.coupling else {}
        return self.arrays | {f"index/{name}": array for name, array in index.items()}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        if self.coupling:
            self.coupling.restore({name[6:]: array for name, array in arrays.items() if name.startswith("index/")})

    @property
    def field_names(self) -> list[str]:
        return ["id", "position", "velocity", "mass", "density", "stress"]

    def field(self, name: str) -> np.ndarray:
        own = {"density": np.full(self.n_points, self._density), "stress": np.zeros((self.n_points, 6))}
        return own[name] if name in own else self.arrays[name]


@pytest.fixture(autouse=True, scope="module")
def registered():
    with forgotten_afterwards():
        register(SpringLatticeCase)
        yield


def lattice(**more):
    table = {
        "kind": "spring-lattice",
        "name": "lattice",
        "field": "lattice",
        "corner": (3.1, 2.0, 2.0),
        "edge": 2.0,
        "stiffness": 5e4,
        "material": RATE_SOLID,
        "velocity": (-0.5, 0.0, 0.0),
    }
    return table | more


def collision(**more):
    """A lattice that flies against a block at rest, 0.1 m away; none other acts on either."""
    block = box((1, 2, 2), (3, 4, 4), SOLID, (2, 2, 2), name="block")
    contact = [{"name": "hit", "between": ("block", "lattice"), "kind": "frictionless"}]
    return simulation(block, lattice(), counts=(8, 6, 6), contact=contact, end=1.0, courant=0.2, **more)


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_it_hits_a_block_by_contact(scheme):
    sim = collision(scheme=scheme)
    block, springs = sim.bodies
    before, energy = springs.totals.momentum.copy(), sum(sim.budget.energies()[name] for name in ("kinetic", "strain"))
    while sim.time < 0.9:
        sim.step()
    push = sim.budget.reactions()["hit"]
    assert push[0] < -0.3 * np.abs(before[0])
    assert block.totals.momentum == pytest.approx(push, abs=1e-12 * np.abs(before).max())
    assert springs.totals.momentum - before == pytest.approx(-push, abs=1e-12 * np.abs(before).max())
    assert springs.totals.stored > 0.0
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert sim.budget.energies()["contact_work"] < 0.0
    assert abs(sim.budget.conservation()["energy"]) < 0.1 * energy / sim.budget.energy_scale, (
        "backward Euler and contact take some"
    )


def test_its_nodes_keep_their_order_and_a_restart_its_bits():
    whole = advance(collision(), 60)
    first = advance(collision(), 30)
    again = collision()
    again.restore({name: array.copy() for name, array in first.state_arrays().items()}, first.state_numbers())
    advance(again, 30)
    assert np.array_equal(whole.bodies[1].arrays["id"], np.arange(PER_SIDE**3))
    for name, array in whole.state_arrays().items():
        assert np.array_equal(array, again.state_arrays()[name]), name


def test_a_case_file_can_name_it_and_its_run_goes_on_from_a_checkpoint(tmp_path):
    table = lattice(initial_stretch=0.01)
    alone = Case.model_validate({"schema": 1, "title": "alone", "time": {"end": 0.5, "step": 0.01}, "body": [table]})
    file = tmp_path / "lattice.toml"
    file.write_text(dumps(alone), encoding="utf-8")
    case = load(file)
    assert case.body[0] == alone.body[0]
    whole = run_case(case, tmp_path / "whole", threads=1, report=False)
    run_case(case, tmp_path / "part", threads=1, until=0.2, report=False)
    gone_on = resume_case(tmp_path / "part", threads=1, report=False)
    assert gone_on.finished
    for name, column in whole.history.items():
        assert np.array_equal(column, gone_on.history[name]), name


def test_alone_it_needs_no_grid(tmp_path):
    """Stretched at the start it swings, keeps its momentum, and a run of it leaves all that runs leave."""
    table = lattice(initial_stretch=0.01)
    case = Case.model_validate({"schema": 1, "title": "alone", "time": {"end": 1.0, "step": 0.01}, "body": [table]})
    assert "grid" not in case.to_data()
    run = run_case(case, tmp_path / "run", threads=1, report=False)
    kinetic, strain = run.history["kinetic_energy"], run.history["strain_energy"]
    assert strain.min() < 0.2 * strain[0] < kinetic.max()
    assert np.abs(run.history["momentum_x"] - run.history["momentum_x"][0]).max() < 1e-9 * np.abs(run.history["momentum_x"][0])
    assert run.summary["conservation"]["energy"] < 0.0, "backward Euler takes some"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (
            {"support": [{"where": "x-lower"}]},
            "support.0.where: needs a grid, and this case has none: faces belong to a grid",
        ),
        ({"absorbing": [{"where": "x-lower", "body": "lattice"}]}, "absorbing.0.where: needs a grid"),
        (
            {"contact": [{"between": ["lattice", "none"]}]},
            "contact.0.between: needs a grid, .* contact needs a grid",
        ),
    ],
)
def test_what_needs_a_grid_beside_it_says_so(more, words):
    with pytest.raises(ValidationError, match=words):
        Case.model_validate({"schema": 1, "title": "alone", "time": {"end": 1.0}, "body": [lattice()], **more})


def test_beside_another_it_needs_one():
    tables = [lattice(), lattice(name="other", field="other", corner=(0.0, 2.0, 2.0))]
    with pytest.raises(ValidationError, match="bodies lattice, other need one"):
        Case.model_validate({"schema": 1, "title": "two", "time": {"end": 1.0}, "body": tables})


def test_conditions_act_on_it():
    """Gravity and a load on all of it, and a support on part of it: momentum and energy are accounted for."""
    load = [{"kind": "body-force", "body": "lattice", "acceleration": (0.3, 0.0, 0.0)}]
    floor = {"name": "floor", "where": {"box": {"lower": (0, 0, 0), "upper": (8, 2.6, 8)}}, "fix": ("x", "y", "z")}
    sim = simulation(
        lattice(velocity=(0, 0, 0)), counts=(8, 6, 6), gravity=(0, -2.0, 0), support=[floor], end=1.0, step=0.01, load=load
    )
    while sim.time < 0.3:
        sim.step()
    body = sim.bodies[0]
    low = body.arrays["start"][:, 1] < 2.6
    assert np.array_equal(body.arrays["position"][low], body.arrays["start"][low])
    assert body.arrays["velocity"][~low].any()
    energies = sim.budget.energies()
    assert energies["gravity_work"] > 0.0
    assert energies["load_work"] > 0.0
    assert sim.budget.reactions()["floor"][1] > 0.0
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert sim.budget.conservation()["energy"] < 0.0, "backward Euler takes some"


def test_it_cannot_follow_a_motion():
    motion = [{"name": "pull", "body": "lattice", "hold": ("x",)}]
    with pytest.raises(ValidationError, match="cannot follow a prescribed motion"):
        simulation(lattice(), counts=(8, 6, 6), motion=motion)
