"""Three conditions in one file: forces, a loss on the nodes, and damping of a body as a whole, each with channel and key.

Nothing else of the package knows them. The key of a condition of the package is a line of `case/spec.py`; a case with these
keys stands in for it here.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from pellucid import CaseError, loads
from pellucid.case import Case, dumps, reading
from pellucid.case import load as load_case
from pellucid.energy import Channel, StepWork
from pellucid.errors import RunStopped, UnknownName
from pellucid.findings import Finding
from pellucid.model import Vector, parameter
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.results.storage.history import read
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation.simulation import Simulation
from pellucid.step.part import StepPart

BRAKE_HEAT, SPIN_HEAT = Channel("brake_heat", -1.0), Channel("spin_heat", -1.0)


class Thrust(Condition):
    """A force on a body, shared by mass."""

    body: str = parameter("", "name of the body")
    force: Vector = parameter("N", "force on the body")

    def problems(self, path: tuple, parts: Parts) -> Iterator[Finding]:
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)

    def load_channel(self) -> str:
        return "thrust_work"

    @classmethod
    def activate(cls, conditions: Sequence["Thrust"], assembly: Assembly) -> Sequence[StepPart]:
        return [ActiveThrust(thrust, assembly) for thrust in conditions]


class ActiveThrust(StepPart):
    def __init__(self, thrust: Thrust, assembly: Assembly) -> None:
        self._body, self._force = assembly.bodies[thrust.body].body, np.array(thrust.force)
        self._add = assembly.forces_on(thrust.body, thrust.load_channel())

    def begin(self, time: float, dt: float) -> None:
        mass = self._body.arrays["mass"]
        self._add(mass[:, None] / mass.sum() * self._force)


class Brake(Condition):
    """A medium in part of the grid that takes momentum from the nodes in it: m v fades at a rate."""

    field: str = parameter("", "velocity field of the bodies that it brakes")
    rate: float = parameter("1/s", "rate at which velocities fade", ge=0)
    above: float = parameter("m", "it fills the grid above this x")

    def channels(self) -> Sequence[Channel]:
        return (BRAKE_HEAT,)

    @classmethod
    def activate(cls, conditions: Sequence["Brake"], assembly: Assembly) -> Sequence[StepPart]:
        return [ActiveBrake(brake, assembly) for brake in conditions]


class ActiveBrake(StepPart):
    def __init__(self, brake: Brake, assembly: Assembly) -> None:
        (self._field,) = (actions.field for actions in assembly.actions if actions.field.name == brake.field)
        self._rate, self._column = brake.rate, assembly.layout.column(BRAKE_HEAT)
        self._inside = np.zeros((self._field.grid.n_nodes, 1), bool)
        index, position = self._field.grid.where()
        self._inside[index, 0] = position[:, 0] >= brake.above

    def act_on_nodes(self, dt: float) -> None:
        nodes = self._field.grid.nodes
        taken = np.where(self._inside, np.expm1(-self._rate * dt) * nodes.mass[:, None] * nodes.velocity, 0.0)
        self._field.add_impulses(taken, self._column, sign=-1.0)


class SpinDamping(Condition):
    """Lets the spin of a body fade, which keeps its momentum."""

    body: str = parameter("", "name of the body")
    rate: float = parameter("1/s", "rate at which the angular momentum fades", ge=0)

    def channels(self) -> Sequence[Channel]:
        return (SPIN_HEAT,)

    @classmethod
    def activate(cls, conditions: Sequence["SpinDamping"], assembly: Assembly) -> Sequence[StepPart]:
        return [ActiveSpinDamping(assembly.bodies[damping.body], damping.rate, assembly) for damping in conditions]


class ActiveSpinDamping(StepPart):
    strains, top_speed = True, 0.0

    def __init__(self, member: AssembledBody, rate: float, assembly: Assembly) -> None:
        self._body, self._rate, self._layout = member.body, rate, assembly.layout
        self._dt = self._heat = 0.0
        member.body.constrain(self)

    def begin(self, time: float, dt: float) -> None:
        self._dt = dt

    def prescribe_velocities(self) -> None:
        arrays = self._body.arrays
        m, x, v = arrays["mass"][:, None], arrays["position"], arrays["velocity"]
        r = x - np.sum(m * x, axis=0) / m.sum()
        spin, inertia = np.sum(m * np.cross(r, v), axis=0)[2], np.sum(m * r[:, :2] ** 2)
        before = 0.5 * np.sum(m * v * v)
        v += np.expm1(-self._rate * self._dt) * np.cross((0.0, 0.0, spin / inertia), r)
        self._heat = float(before - 0.5 * np.sum(m * v * v))

    def prescribe_positions(self) -> None:
        """The points move with the grid."""

    def work(self) -> StepWork:
        done = self._layout.no_work()
        done.works[self._layout.column(SPIN_HEAT)] = self._heat
        return done


class CaseWithThem(Case):
    thrust: tuple[Thrust, ...] = parameter("", "forces on bodies", ())
    brake: tuple[Brake, ...] = parameter("", "media that brake", ())
    spin_damping: tuple[SpinDamping, ...] = parameter("", "bodies whose spin fades", ())


@pytest.fixture(autouse=True)
def _keys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "Case", CaseWithThem)


GRID = """
schema = 1
title = "Conditions of one file"
[grid]
lower = [-2, -2, 0]
upper = [2, 2, 0]
cell = 0.25
functions = "trilinear"
[time]
end = 0.2
step = 1e-3
[output]
history = 0.01
"""
BLOCK = """
[[body]]
name = "block"
shape = { box = { lower = [-0.5, -0.5, 0], upper = [0.5, 0.5, 0] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""
THRUST = '[[thrust]]\nbody = "block"\nforce = ["2 kN", 0, 0]\n'
BRAKE = '[[brake]]\nfield = "common"\nrate = 5\nabove = -2\n'
SPIN = '[[spin_damping]]\nbody = "block"\nrate = 8\n'
ALL = (
    GRID
    + BLOCK
    + "velocity = [0.5, 0, 0]\nangular_velocity = [0, 0, 2]\n"
    + BLOCK.replace('"block"', '"other"').replace("-0.5, -0.5", "0.54, -0.5").replace("[0.5, 0.5", "[1.54, 0.5")
    + 'field = "apart"\n'
    + THRUST
    + BRAKE.replace("-2", "0")
    + SPIN
    + '[[support]]\nwhere = "x-upper"\nfix = "normal"\n'
    + '[[probe]]\nname = "speed"\nbody = "block"\nquantity = "velocity"\ncomponent = "x"\n'
)


def test_each_is_a_table_of_the_case_with_messages_and_settings(tmp_path: Path) -> None:
    case = loads(ALL)
    assert case.thrust[0].force == (2000.0, 0.0, 0.0)
    (tmp_path / "again.toml").write_text(dumps(case), encoding="utf-8")
    assert load_case(tmp_path / "again.toml") == case
    assert case.with_settings({"brake.0.rate": 7.0}).brake[0].rate == 7.0
    for before, after, words in (
        ('body = "block"\nforce', 'body = "blok"\nforce', "did you mean `block`?"),
        ("rate = 8", "rate = -8", "spin_damping.0.rate = -8"),
        ('name = "speed"', 'name = "thrust_work"', "the name is reserved for a column of the history"),
        ('name = "speed"', 'name = "brake_heat"', "the name is reserved for a column of the history"),
    ):
        assert before in ALL
        with pytest.raises(CaseError) as caught:
            loads(ALL.replace(before, after))
        assert words in str(caught.value)


def test_without_them_a_case_does_not_know_their_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "Case", Case)
    with pytest.raises(CaseError, match="thrust"):
        loads(ALL)


def test_thrust_and_brake_of_a_body_that_does_not_deform_are_exact(tmp_path: Path) -> None:
    """v' = F/m - β v in steps: (v + dt F/m) e^(-β dt); every joule is in one of the two channels."""
    run_case(loads(GRID + BLOCK + THRUST + BRAKE), out=tmp_path / "run", report=False)
    history = read(tmp_path / "run" / "history.csv")
    assert list(history)[6:10] == ["gravity_work", "support_work", "thrust_work", "brake_heat"]
    mass, dt, v, pushed = 1000.0, 1e-3, 0.0, 0.0
    for _ in range(200):
        new = (v + dt * 2.0) * np.exp(-5.0 * dt)
        pushed += dt * 2000.0 * 0.5 * (v + new)
        v = new
    assert history["momentum_x"][-1] == pytest.approx(mass * v, rel=1e-11)
    assert history["thrust_work"][-1] == pytest.approx(pushed, rel=1e-11)
    assert history["brake_heat"][-1] == pytest.approx(pushed - 0.5 * mass * v**2, rel=1e-9)
    assert np.abs(history["energy_error"]).max() < 1e-12


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_spin_fades_at_its_rate_and_its_energy_is_heat(tmp_path: Path, scheme: str) -> None:
    grid = GRID.replace("step = 1e-3", f'step = 1e-3\nscheme = "{scheme}"')
    run_case(loads(grid + BLOCK + "angular_velocity = [0, 0, 0.2]\n" + SPIN), out=tmp_path / "run", report=False)
    history = read(tmp_path / "run" / "history.csv")
    assert list(history)[6:9] == ["gravity_work", "support_work", "spin_heat"]
    start, end = history["kinetic_energy"][[0, -1]]
    assert history["spin_heat"][-1] == pytest.approx(start - end, rel=0.02)
    assert end == pytest.approx(start * np.exp(-2 * 8 * 0.2), abs=0.02 * start), "the rest shakes the edges of the block"
    assert np.abs(history["energy_error"]).max() < 0.01


def test_all_together_balance_resume_and_are_the_same_bits_on_two_threads(tmp_path: Path) -> None:
    """With contact, whose impulses come behind those of the brake, and a support."""
    case = loads(ALL)
    whole = run_case(case, out=tmp_path / "one", threads=1, report=False)
    history, summary = whole.history, whole.summary
    own = ["thrust_work", "brake_heat", "spin_heat"]
    assert list(history)[6:12] == ["gravity_work", "support_work", *own, "contact_work"]
    assert all(history[name][-1] > 0.0 for name in own)
    assert history["contact_work"][-1] < 0.0
    assert abs(summary["conservation"]["momentum"]) < 1e-12
    assert np.abs(history["energy_error"]).max() < 0.01
    run_case(case, out=tmp_path / "two", threads=2, report=False)
    run_case(case, out=tmp_path / "parts", threads=1, until=0.11, report=False)
    resume_case(tmp_path / "parts", threads=2, report=False)
    bits = (tmp_path / "one" / "history.csv").read_bytes()
    assert (tmp_path / "two" / "history.csv").read_bytes() == bits
    assert (tmp_path / "parts" / "history.csv").read_bytes() == bits


def test_two_conditions_cannot_lead_the_points_of_a_body(tmp_path: Path) -> None:
    text = GRID + BLOCK + "rigid = true\n" + SPIN
    with pytest.raises(ValueError, match="the motion of the points of body block is already prescribed"):
        run_case(loads(text), out=tmp_path / "run", report=False)


def set_up(text: str, monkeypatch: pytest.MonkeyPatch, owner: type, **methods: object) -> Simulation:
    """The simulation of a case with other methods of a class of this file."""
    for name, method in methods.items():
        monkeypatch.setattr(owner, name, method)
    return Simulation(loads(text), threads=1)


@pytest.mark.parametrize(
    ("force", "given"),
    [
        (np.ones((1, 3)), r"an array of float64 of shape \(1, 3\)"),
        (np.ones((63, 3)), r"an array of float64 of shape \(63, 3\)"),
        (np.ones(3), r"an array of float64 of shape \(3,\)"),
        (np.full((64, 3), None), r"an array of object of shape \(64, 3\)"),
        ([[0.0, 0.0, 0.0]], "list"),
        (None, "NoneType"),
    ],
)
def test_forces_of_another_shape_are_refused(force: object, given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels read a row for each point, without a check."""
    sim = set_up(GRID + BLOCK + THRUST, monkeypatch, ActiveThrust, begin=lambda self, time, dt: self._add(force))
    assert sim.bodies[0].n_points == 64
    words = rf"`Thrust` \(.*test_own_conditions.py\) adds forces to body block as {given}; .* of shape \(64, 3\) is required"
    with pytest.raises(RunStopped, match=words):
        sim.step()


@pytest.mark.parametrize(
    ("method", "name", "words"),
    [
        ("load_channel", "gravity_work", "another column of the history has this name"),
        ("load_channel", "thrust_heat", "not a valid name"),
        ("channels", "kinetic_energy", "another column of the history has this name"),
        ("channels", "energy_error", "another column of the history has this name"),
        ("channels", "staggering_energy", "another column of the history has this name"),
        ("channels", "kick", "not a valid name"),
        ("channels", "kick work", "not a valid name"),
        ("channels", "Kick_heat", "not a valid name"),
    ],
)
def test_a_channel_has_a_name_of_its_own(method: str, name: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is a column of the history, where two of a name could not be read."""
    found = name if method == "load_channel" else (Channel(name),)
    with pytest.raises(CaseError, match=rf"(?s)`Thrust` .* the .*channel `{name}` .*{words}.*Choose another name"):
        set_up(GRID + BLOCK + THRUST, monkeypatch, Thrust, **{method: lambda self: found})


def test_a_channel_that_no_condition_declares_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UnknownName, match=r"no channel `brake_heat .sign -1.`; available: .*thrust_work .sign 1."):
        set_up(GRID + BLOCK + THRUST + BRAKE, monkeypatch, Brake, channels=lambda self: ())
    monkeypatch.undo()
    monkeypatch.setattr(reading, "Case", CaseWithThem)
    with pytest.raises(UnknownName, match=r"`Thrust` .*no condition returns this channel from `load_channel`: `pull_work`"):
        set_up(
            GRID + BLOCK + THRUST,
            monkeypatch,
            Thrust,
            channels=lambda self: (Channel("pull_work"),),
            activate=lambda conditions, assembly: [assembly.forces_on("block", "pull_work")] if conditions else [],
        )


@pytest.mark.parametrize("found", [None, [1.0], ActiveThrust])
def test_what_activate_returns_must_be_parts(found: object, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CaseError, match=r"(?s)`activate` of `Thrust` .*own_conditions.py\) returns .*`StepPart`"):
        set_up(GRID + BLOCK + THRUST, monkeypatch, Thrust, activate=lambda conditions, assembly: found)


def test_an_array_of_points_that_is_not_declared_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def add_array(self: ActiveThrust) -> None:
        self._body.arrays["dye"] = np.zeros(self._body.n_points)

    monkeypatch.setattr(ActiveThrust, "try_out", add_array)
    with pytest.raises(UnknownName, match=r"(?s)array `dye` of points is not declared.*`point_fields`.*`fields`"):
        run_case(loads(GRID + BLOCK + THRUST), out=tmp_path / "run", report=False)
