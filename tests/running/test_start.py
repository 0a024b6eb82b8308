"""Cases that go on from the state of an earlier run."""

import shutil
import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from pellucid.case import Case, load, loads
from pellucid.cli import app
from pellucid.errors import CaseError, UsageError
from pellucid.running.launch import resume_case, run_case

TANK = """
schema = 1
title = "Two blocks in flight"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.25
functions = "quadratic-bspline"
[time]
end = 0.2
transfer = "TRANSFER"
[[body]]
name = "gas"
kind = "material-points"
shape = { box = { lower = [0.5, 0.5, 0], upper = [1.5, 1.5, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "fluid", density = 1.0, pressure = 1.0, eos = { kind = "ideal-gas", gamma = 1.4 } }
velocity = [1, 0, 0]
[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [2.5, 0.5, 0], upper = [3.0, 1.5, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
velocity = [-1, 0.2, 0]
[output]
frames = 0.1
"""


def tank(transfer: str = "flip", **settings: object) -> Case:
    return loads(TANK.replace("TRANSFER", transfer)).with_settings(settings)


def going_on(case: Case, folder: object, **start: object) -> Case:
    return case.with_settings({"start": {"path": str(folder)} | start})


def fields(run, body):
    return run.fields(body)


@pytest.mark.parametrize("transfer", ["flip", "apic"])
def test_two_halves_are_the_whole(tmp_path, transfer):
    """From a checkpoint a run goes on as if it had not ended: the order of the points changes sums by rounding alone."""
    half = tank(transfer, **{"time.step": 1e-3})
    first = run_case(half.with_settings({"time.end": 0.1}), tmp_path / "first", report=False)
    second = run_case(going_on(half, first.out).with_settings({"time.end": 0.1}), tmp_path / "second", report=False)
    whole = run_case(half, tmp_path / "whole", report=False)
    for body in ("gas", "block"):
        for name in ("position", "velocity", "stress"):
            expected, found = fields(whole, body)[name], fields(second, body)[name]
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * abs(expected).max())
    assert second.summary["end_time"] == pytest.approx(0.1)


def test_a_frame_is_a_start_too_for_some_bodies(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    case = going_on(tank(), first.out, time=0.1, body=["gas"]).with_settings({"body.block.velocity": [0, 0, 0]})
    second = run_case(case, tmp_path / "second", until=1e-9, report=False)
    at = first.fields("gas", 0.1)
    for name in ("position", "velocity", "density", "internal_energy"):
        np.testing.assert_allclose(second.fields("gas", 0.0)[name], at[name], rtol=1e-13)
    assert not second.fields("block", 0.0)["velocity"].any()


def test_the_balance_begins_with_the_state(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    second = run_case(going_on(tank(), first.out), tmp_path / "second", report=False)
    for name in ("kinetic_energy", "internal_energy"):
        assert second.history[name][0] == pytest.approx(first.history[name][-1], rel=1e-12)
    assert abs(second.summary["conservation"]["energy"]) < 1e-3


def test_a_run_that_went_on_is_resumed_bit_for_bit(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    part = {"box": {"lower": [2.1, 0, 0], "upper": [2.45, 2, 0]}}  # where the block is now, and was not
    motion = {
        "name": "grip",
        "body": "block",
        "part": part,
        "displacement": {"x": {"kind": "steady", "velocity": 0.1}},
    }
    case = going_on(tank(), first.out).with_settings({"motion": [motion]})
    expected = run_case(case, tmp_path / "whole", report=False)
    stopped = run_case(case, tmp_path / "stopped", until=0.1, report=False)
    (stopped.folder.checkpoint).stat()
    resumed = resume_case(stopped.out, report=False)
    assert resumed.folder.history.read_bytes() == expected.folder.history.read_bytes()


def test_a_run_is_not_resumed_from_another_start(tmp_path):
    first = run_case(tank(), tmp_path / "first", until=0.1, report=False)
    second = run_case(going_on(tank(), first.out), tmp_path / "second", until=0.1, report=False)
    resume_case(first.out, report=False)
    with pytest.raises(UsageError, match=r"earlier run that provides the initial state \(start.path\) has changed"):
        resume_case(second.out, report=False)


def test_a_run_does_not_replace_the_one_that_it_starts_from(tmp_path):
    first = run_case(tank(), tmp_path / "first", until=0.1, report=False)
    with pytest.raises(UsageError, match="is the initial state of the case"):
        run_case(going_on(tank(), first.out), first.out)
    assert first.history["time"][-1] == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    "case", ["basics/elastic-block-drop", "benet2015/compressed-vesicle", "benet2015/diffusion", "lian2014/airbag"]
)
def test_bodies_of_every_family_go_on(tmp_path, case):
    case = load(case).quick_variant()
    end = case.time.end / 10 if case.id != "lian2014/airbag" else case.time.end / 50
    first = run_case(case, tmp_path / "first", until=end, report=False)
    second = run_case(going_on(case, first.out), tmp_path / "second", until=end / 1e6, report=False)
    for body in (body.name for body in case.body):
        before, now = first.fields(body), second.fields(body, 0.0)
        assert before.keys() == now.keys()
        for name in before.keys() - ({"velocity"} if case.grid_or_none is None else set()):  # of films, by loads that are new
            scale = max(abs(before[name]).max(), 1e-300)
            np.testing.assert_allclose(now[name], before[name], rtol=0.0, atol=1e-9 * scale, err_msg=f"{body} {name}")


SOLID = {"kind": "linear-elastic", "density": 1.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
MOVED = {"body.block.shape.box.lower": [2.0, 0.5, 0], "body.block.shape.box.upper": [2.5, 1.5, 0]}
SHORTER = {"grid.upper": [2.5, 2, 0], **MOVED}


@pytest.fixture(scope="module")
def earlier(tmp_path_factory):
    """A run from which others start, and which none changes."""
    return run_case(tank(), tmp_path_factory.mktemp("earlier") / "first", report=False)


@pytest.mark.parametrize(
    ("start", "changes", "words"),
    [
        ({"path": "nowhere"}, {}, r"start\.path = .*nowhere.*\n.*it does not exist"),
        ({"body": []}, {}, r"start\.body = \[\]\n.*is empty\n.*Remove this key for all"),
        ({}, {"body.gas.velocity": [2, 0, 0]}, r"body\.gas\.velocity = \[2.*\n.*has no effect.*the value was \[1"),
        ({}, {"body.gas.angular_velocity": [0, 0, 1]}, r"gas\.angular_velocity = .*\n.*has no effect(.|\n)*Remove this key"),
        ({}, {"body.block.initial_stress": [1, 0, 0, 0, 0, 0]}, r"block\.initial_stress = .*\n.*has no effect"),
        ({}, {"body.gas.material.pressure": 2.0}, r"gas\.material\.pressure = 2.*\n.*has no effect.*the value was 1"),
        ({}, {"grid.thickness": 0.5}, r"grid\.thickness = 0\.5\n.*1 m thick along z, but this grid is 0\.5 m thick"),
        ({"body": ["gass"]}, {}, r"no body has this name; available: gas, block"),
        ({"time": 7.0}, {}, r"start\.time = 7(.|\n)*its last at 0\.2 s"),
        ({}, {"body.gas.points_per_cell": [1, 1, 1]}, r"body gas has 16 points, but 64 in the earlier run"),
        ({}, SHORTER, r"points of body block are outside the grid(.|\n)*Enlarge the grid"),
        (
            {},
            {"body.gas.material": SOLID},
            r"material.kind = \"linear-elastic\"(.|\n)*in which the body had material.kind = fluid",
        ),
    ],
)
def test_a_start_that_does_not_fit_is_an_error_of_the_case(tmp_path, earlier, start, changes, words):
    def run():
        case = tank().with_settings({**changes, "start": {"path": str(earlier.out), **start}})
        run_case(case, tmp_path / "second", report=False)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the places of shapes
        with pytest.raises(CaseError, match=words):
            run()
    assert not (tmp_path / "second").exists()


def test_what_the_shape_says_of_the_place_is_told_to_be_of_no_effect(tmp_path, earlier):
    with pytest.warns(
        UserWarning, match="block keeps its position in .*; its `shape`, which differs from this run, has no effect"
    ):
        second = run_case(going_on(tank(**MOVED), earlier.out), tmp_path / "second", until=1e-9, report=False)
    np.testing.assert_allclose(second.fields("block", 0.0)["position"], earlier.fields("block")["position"], rtol=1e-12)


FLEET = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}


def follower(name, left, velocity, **more):
    """A block 1 m wide, of one of the fields."""
    return {
        "name": name,
        "kind": "material-points",
        "shape": {"box": {"lower": [left, 0.5, 0], "upper": [left + 1.0, 1.5, 0]}},
        "points_per_cell": [2, 2, 1],
        "material": FLEET,
        "velocity": [velocity, 0, 0],
    } | more


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Two blocks of two velocity fields, one behind the other: the first is where the second was."""
    bodies = [follower("a", 0.25, 5, field="a"), follower("b", 1.5, 5, field="b")]
    case = tank().with_settings({"body": bodies, "time.end": 0.3})
    return run_case(case, tmp_path_factory.mktemp("flown") / "first", report=False)


def test_bodies_that_go_on_may_be_where_others_of_them_were(tmp_path, flown):
    second = run_case(going_on(flown.case, flown.out), tmp_path / "second", until=1e-9, report=False)
    assert second.fields("a", 0.0)["position"][:, 0].mean() > 1.5
    together = flown.case.with_settings({"body.b.field": "a"})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run_case(going_on(together, flown.out), tmp_path / "together", until=1e-9, report=False)


@pytest.mark.parametrize("field", ["a", "c"])
def test_a_new_body_may_be_where_one_that_goes_on_was_but_not_where_it_is(tmp_path, flown, field):
    at = flown.fields("a")["position"][:, 0].mean() - 0.5
    first = follower("a", 0.25, 5, field="a")

    def start(left, **more):
        case = tank().with_settings({"body": [first, follower("c", left, 0.0, field=field, **more)]})
        return run_case(going_on(case, flown.out), tmp_path / "second", until=1e-9, report=False)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start(0.25)
    if field == "a":
        with pytest.warns(UserWarning, match="bodies a and c overlap in one velocity field"):
            start(at)
    else:
        with pytest.raises(CaseError, match="points of this body start inside body c"):
            start(at)


def test_a_body_described_with_less_than_in_the_earlier_run_goes_on(tmp_path, earlier):
    case = going_on(tank(**{"body.gas.velocity": [0, 0, 0]}), earlier.out)
    second = run_case(case, tmp_path / "second", until=1e-9, report=False)
    np.testing.assert_allclose(second.fields("gas", 0.0)["velocity"], earlier.fields("gas")["velocity"], rtol=1e-12)


def test_a_start_from_a_file_says_what_it_is(tmp_path, earlier):
    with pytest.raises(CaseError, match=r"it is a file\n.*Set path = .*first"):
        going_on(tank(), earlier.folder.case)
    (tmp_path / "file").write_text("")
    with pytest.raises(CaseError, match=r"it is a file\n.*folder \(--out\)"):
        going_on(tank(), tmp_path / "file")


@pytest.mark.parametrize("damage", ["schema = ", "schema = 1\n", "\x00", "title = 3\nbody = 7\n"])
def test_a_broken_case_of_the_earlier_run_is_blamed_itself(tmp_path, earlier, damage):
    broken, file = tmp_path / "broken", tmp_path / "new.toml"
    shutil.copytree(earlier.out, broken)
    (broken / "case.toml").write_text(damage)
    file.write_text(TANK.replace("TRANSFER", "flip") + f'[start]\npath = "{broken}"\n')
    result = CliRunner().invoke(app, ["run", str(file), "--out", str(tmp_path / "second")])
    assert result.exit_code == 2
    line = file.read_text().splitlines().index(f'path = "{broken}"') + 1
    assert f"{file}:{line}: start.path" in result.stderr
    assert f"Correct {broken / 'case.toml'}, or set another run." in result.stderr
    assert f"{file}:1:" not in result.stderr


@pytest.mark.parametrize("damage", [lambda data: b"rubbish" * 99, lambda data: data[:500], lambda data: b""])
def test_a_start_from_damaged_fields_is_told(tmp_path, earlier, damage):
    broken = tmp_path / "broken"
    shutil.copytree(earlier.out, broken)
    path = broken / "fields/gas.vtkhdf"
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(CaseError, match=r"start\.time = 0\.1\n.*gas\.vtkhdf is damaged"):
        run_case(going_on(tank(), broken, time=0.1), tmp_path / "second", report=False)
    assert not (tmp_path / "second").exists()


SLIDING = """
schema = 1
title = "A block on a plate that rises and turns"
gravity = [0, -9.81, 0]
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.1
[time]
end = 0.3
step = 1e-3
[[body]]
name = "plate"
field = "plate"
rigid = true
shape = { box = { lower = [0.5, 0.6, 0], upper = [3.5, 0.9, 0] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
[[body]]
name = "block"
field = "block"
shape = { box = { lower = [1.6, 0.9, 0], upper = [2.2, 1.2, 0] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
[[motion]]
name = "turns"
body = "plate"
hold = ["x"]
displacement = { y = { kind = "steady", velocity = 0.3 } }
rotation = { z = { kind = "steady", angular_velocity = -1.0 } }
[[contact]]
between = ["block", "plate"]
kind = "coulomb"
friction = 0.2
[output]
frames = 0.15
"""


def test_bodies_that_moved_touch_where_they_are(tmp_path):
    """A plate that rises and turns, and a soft block on it. From a checkpoint surfaces go on as they were, but for one step
    of slip; from a frame they are found where the points are, and friction begins anew: the block slips until it holds.
    """
    half = loads(SLIDING)
    first = run_case(half.with_settings({"time.end": 0.15}), tmp_path / "first", report=False)
    whole = run_case(half, tmp_path / "whole", report=False)
    for start, most in (({}, 1e-4), ({"time": 0.15}, 2e-3)):
        case = going_on(half, first.out, **start).with_settings({"time.end": 0.15})
        second = run_case(case, tmp_path / f"second{most}", report=False)
        for body in ("plate", "block"):
            expected = fields(whole, body)["position"]
            assert np.abs(expected - fields(first, body)["position"]).max() > 0.02
            np.testing.assert_allclose(fields(second, body)["position"], expected, rtol=0.0, atol=most)
