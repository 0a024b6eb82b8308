"""The time loop: limits on the energy error, signals, restart, and a tube against the exact solution."""

import json
import os
import signal
import threading
import warnings
from itertools import pairwise

import numpy as np
import pytest
from elements import element_sheet
from small_cases import GAS, RATE_SOLID, SLIP, advance, box, case, shear_flow, simulation

import pellucid
from pellucid.compilation.reporting import kernel_key
from pellucid.energy import FIRST_JUDGED
from pellucid.errors import Interrupted, RunStopped, UsageError
from pellucid.references.gas_dynamics import GasState, solve
from pellucid.simulation.loop import recorded_steps
from pellucid.simulation.simulation import Simulation


class Recorder:
    """Notes what the loop tells it."""

    def __init__(self, kill_at=None, number=signal.SIGTERM):
        self.calls, self.kill_at, self.number = [], kill_at, number

    def begin(self, sim):
        self.calls.append("begin")

    def after_step(self, sim):
        self.calls.append(sim.n_steps)
        if sim.n_steps == self.kill_at:
            os.kill(os.getpid(), self.number)

    def checkpoint(self, sim):
        self.calls.append("checkpoint")

    def end(self, sim):
        self.calls.append("end")

    def failed(self, sim, error):
        self.calls.append("failed")


def sphere(**more):
    """A gas ball that is thrown into a corner: points cross many cells and are sorted anew."""
    ball = {"sphere": {"centre": (6.0, 4.0, 4.0), "radius": 2.0}}
    body = box((0, 0, 0), (1, 1, 1), GAS, velocity=(-0.9, -0.8, -0.7)) | {"shape": ball}
    return case(body, counts=(12, 8, 8), support=SLIP, end=3.0, courant=0.3, **more)


def run(sim, recorder, until=None):
    for _ in recorded_steps(sim, recorder, until):
        pass


def test_recorder_sees_every_step():
    recorder = Recorder()
    sim = simulation(box((1, 1, 1), (2, 2, 2)), step=0.1, end=1.0)
    run(sim, recorder)
    assert recorder.calls == ["begin", *range(1, 11), "end"]
    assert sim.time == 1.0


def test_until_stops_early_and_the_run_goes_on_later():
    sim = simulation(box((1, 1, 1), (2, 2, 2)), step=0.1, end=1.0)
    run(sim, Recorder(), until=0.35)
    assert sim.n_steps == 4
    run(sim, Recorder())
    assert (sim.n_steps, sim.time) == (10, 1.0)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_signals_leave_after_the_step_with_a_checkpoint(number, status):
    recorder = Recorder(kill_at=3, number=number)
    before = signal.getsignal(number)
    with pytest.raises(Interrupted) as caught:
        run(simulation(box((1, 1, 1), (2, 2, 2)), step=0.1, end=1.0), recorder)
    assert caught.value.exit_status == status
    assert recorder.calls == ["begin", 1, 2, 3, "checkpoint"]
    assert signal.getsignal(number) is before


def test_runs_in_other_threads_leave_signals_alone():
    recorder = Recorder()
    sim = simulation(box((1, 1, 1), (2, 2, 2)), step=0.25, end=0.5)
    thread = threading.Thread(target=run, args=(sim, recorder))
    thread.start()
    thread.join()
    assert recorder.calls == ["begin", 1, 2, "end"]


def test_a_stopped_run_is_reported():
    recorder = Recorder()
    with pytest.raises(RunStopped):
        run(simulation(box((1, 1, 1), (2, 2, 2), velocity=(3.0, 0, 0)), step=0.1, end=9.0), recorder)
    assert recorder.calls[-1] == "failed"


def test_the_momentum_of_a_step_in_which_a_point_stopped_the_run_is_not_judged():
    """A falling block hits the edge of the grid: gravity gave it momentum in that step too, which the balance does not have."""
    sim = simulation(box((1, 1, 1), (2, 2, 2)), gravity=(0.0, -9.81, 0.0), step=0.05, end=9.0)
    sim.step()
    assert sim.budget.conservation()["momentum"] < 1e-12
    with pytest.raises(RunStopped, match="left the grid"):
        advance(sim, 100)
    assert not sim.budget.is_complete
    assert sim.budget.conservation().keys() == {"mass", "energy"}


def lossy(end=1e6, **energy):
    """Gas that flows to and fro, with an update of its energy that does not follow the work of its forces."""
    gas = {"kind": "fluid", "density": 1.0, "eos": {"kind": "ideal-gas", "gamma": 1.4}, "energy_update": "closed"}
    bodies = [
        box((x, 0, 0), (x + 2, 4, 1), gas | {"pressure": p}, name=name) for x, p, name in ((0, 2.0, "hot"), (2, 1.0, "cold"))
    ]
    return simulation(*bodies, counts=(4, 4, 1), support=SLIP[:4], functions="quadratic-bspline", end=end, energy=energy)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_balance_that_is_no_number_stops_the_run_at_once(wrong):
    sim = lossy(end=1.0)
    sim.step()
    sim.bodies[0].totals.kinetic = wrong  # as where squares of speeds are too large for a number
    sim.budget.kinetic = wrong
    with pytest.raises(RunStopped, match=r"step 1, .* not finite \(infinite or undefined: kinetic.*\n    Check loads"):
        sim._watch.energy(sim.budget, sim.clock, sim.bodies)


def test_gas_at_rest_is_not_judged_by_its_rounding():
    """Nothing moves but rounding: what it makes of 250 J in each m³ must not count as the loss of all that moved."""
    sim = simulation(box((0, 0, 0), (4, 4, 4), GAS | {"pressure": 1e5}), support=SLIP, end=1e6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        advance(sim, 250)
    assert abs(sim.budget.energy_error()) < 1e-4


def test_a_large_energy_error_warns_and_stops():
    sim = lossy(warn=0.05, stop=0.9999)
    with pytest.warns(UserWarning, match=r"the energy error is .* above energy.warn = 5 %"):
        advance(sim, FIRST_JUDGED)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        advance(sim, 3)  # warned once is enough
    with pytest.raises(RunStopped, match=r"above energy.stop = 10 %, fastest point: number .*\n    Use a smaller time step"):
        advance(lossy(warn=0.05, stop=0.1), FIRST_JUDGED)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_work_that_is_no_number_stops_the_run_in_the_next_step(wrong):
    sim = lossy()
    sim.step()
    name = next(iter(sim.budget.sums))
    sim.budget.sums[name] = wrong
    with pytest.raises(
        RunStopped, match=rf"step 2, time .* s: the energy balance is not finite \(infinite or undefined: {name}.*fastest point"
    ):
        sim.step()


def test_early_steps_are_not_judged():
    sim = lossy(warn=1e-9, stop=1e-8)
    advance(sim, FIRST_JUDGED - 1)
    with pytest.raises(RunStopped):
        sim.step()


def test_a_run_of_few_steps_is_judged_at_its_end():
    sim = lossy(5e-3, warn=1e-9, stop=1e-8)
    with pytest.raises(RunStopped, match=r"above energy.stop"):
        advance(sim, FIRST_JUDGED)
    assert sim.time == 5e-3
    assert sim.clock.n_steps < FIRST_JUDGED


@pytest.mark.parametrize(
    "tables",
    [sphere(), sphere(functions="quadratic-bspline", transfer="apic"), shear_flow()],
    ids=["flip", "apic", "mixing"],
)
def test_restart_goes_on_bit_for_bit(tables):
    """Through JSON and fresh arrays, at every step of a stretch that holds a sorting: of points that left their slab, or in
    the last case of points that mixed within it."""
    undisturbed = Simulation(tables, threads=1)
    kept, sortings = [], []
    for step in range(26):
        since = undisturbed.bodies[0].storage.short_runs  # the last sorting
        arrays = {name: array.copy() for name, array in undisturbed.state_arrays().items()}
        kept.append((arrays, json.dumps(undisturbed.state_numbers())))
        undisturbed.step()
        if undisturbed.bodies[0].storage.short_runs is not since:
            sortings.append(step)
    assert sortings, "points left_slab and were sorted on the way"
    found = undisturbed.state_arrays()
    for start in range(sortings[0] - 2, sortings[0] + 2):
        arrays, numbers = kept[start]
        other = Simulation(tables, threads=1)
        other.restore(arrays, json.loads(numbers))
        assert other.n_steps == start
        advance(other, 26 - start)
        assert json.dumps(other.state_numbers()) == json.dumps(undisturbed.state_numbers())
        for name, array in other.state_arrays().items():
            assert array.dtype == found[name].dtype
            assert np.array_equal(array, found[name]), name
        assert other.budget.energies() == undisturbed.budget.energies()


def test_points_that_mix_are_sorted_at_the_same_steps_on_two_threads():
    one, two = (advance(Simulation(shear_flow(), threads=n), 26) for n in (1, 2))
    assert one.bodies[0].arrays["id"].tolist() != sorted(one.bodies[0].arrays["id"])
    for name, array in one.state_arrays().items():
        assert two.state_arrays()[name].tobytes() == array.tobytes(), name


def test_sorting_changes_no_more_than_the_order_of_sums():
    one, other = Simulation(sphere(), threads=1), Simulation(sphere(), threads=1)
    for _ in range(12):
        one.step()
        other.bodies[0].storage.sort()
        other.step()
    frames = one.bodies[0].frame(), other.bodies[0].frame()
    for name in ("position", "velocity", "stress", "internal_energy"):
        # twelve steps with different rounding of nodal sums, numbers of order eight at most
        assert np.abs(frames[0][name] - frames[1][name]).max() < 1e-12, name


def test_timers_split_the_step():
    sim = Simulation(sphere(), threads=1, timed=True)
    advance(sim, 2)
    assert set(sim.timers) >= {"scatter", "grid", "sort"}
    assert all(seconds > 0.0 for seconds in sim.timers.values())


def test_what_a_simulation_tells():
    sim = simulation(box((1, 1, 1), (3, 3, 3), RATE_SOLID, velocity=(0.1, 0.2, 0.3)))
    assert (sim.time, sim.n_steps, sim.dt) == (0.0, 0, 0.0)
    assert sim.momentum() == pytest.approx(np.array([0.1, 0.2, 0.3]) * 8000.0)
    sim.step()
    assert sim.dt == sim.time > 0.0
    assert sim.bodies[0].n_points == 64


def tube_error(cells, functions, cell_pressure):
    """Relative L1 error of the density of Sod's tube, at the points."""
    gas = GAS | {"artificial_viscosity": {"quadratic": 2.0, "linear": 1.0}}
    thin, more = gas | {"density": 0.125, "pressure": 0.1}, {"cell_pressure": cell_pressure}
    left = box((0, 0, 0), (0.5, 1, 1), gas, (4, 1, 1), name="left", **more)
    right = box((0.5, 0, 0), (1, 1, 1), thin, (4, 1, 1), name="right", **more)
    grid = {"counts": (cells, 1, 1), "cell": 1.0 / cells, "functions": functions}
    sim = simulation(left, right, **grid, support=SLIP[:2], end=0.2, energy={"warn": 0.05})
    while not sim.clock.finished(None):
        sim.step()
    exact = solve(GasState(1.0, 0.0, 1.0, 1.4), GasState(0.125, 0.0, 0.1, 1.4))
    error = total = 0.0
    for body in sim.bodies:
        frame = body.frame()
        density = exact.sample((frame["position"][:, 0] - 0.5) / 0.2)["density"]
        # weights: the points' lengths
        length = frame["mass"] / frame["density"]
        error += length @ np.abs(frame["density"] - density)
        total += length @ density
    return error / total


@pytest.mark.parametrize(
    ("functions", "cell_pressure"), [("trilinear", True), ("quadratic-bspline", False), ("quadratic-bspline", True)]
)
def test_shock_tube_errors_fall_under_refinement(functions, cell_pressure):
    """Linear functions with the pressure summed over points are left out: what points do that cross cells stays from 100 on."""
    errors = [tube_error(cells, functions, cell_pressure) for cells in (25, 50, 100)]
    assert errors[2] < 0.03
    # between the first order of a shock and the 2/3 of a contact under an artificial viscosity, on coarse grids
    rates = [one / other for one, other in pairwise(errors)]
    assert min(rates) > 1.4
    assert max(rates) < 2.2


def test_kernels_of_lines_planes_and_volumes_are_told_apart():
    """Thin axes have functions of their own, so a first plane problem after a first line problem compiles again."""
    keys = {
        kernel_key(case(box((0, 0, 0), (2, 2, 2)), counts=counts)) for counts in ((3, 1, 1), (3, 3, 1), (3, 3, 3), (4, 4, 4))
    }
    assert len(keys) == 3


def test_kernels_of_wrinkling_and_of_either_hourglass_control_are_told_apart():
    sheets = [
        element_sheet(),
        element_sheet(thickness=0.02, name="other"),
        element_sheet() | {"material": element_sheet()["material"] | {"wrinkling": True}},
        element_sheet(hourglass={"kind": "viscous"}),
        element_sheet("neo-hookean-membrane"),
    ]
    keys = [kernel_key(case(sheet, counts=(8, 8, 8), cell=0.5, lower=(-2.0, -2.0, -2.0))) for sheet in sheets]
    assert keys[0] == keys[1], "numbers and names do not count"
    assert len(set(keys)) == 4


def test_slabs_without_points_report_nothing_after_a_restart():
    """Kernels pass over them, and would leave the sums of the start there."""
    sim = simulation(box((0, 0, 0), (2, 2, 2)), counts=(40, 2, 2))
    slabs = sim.bodies[0].storage.slabs
    assert (np.diff(slabs.first) == 0).any()
    slabs.sums[:], slabs.fault[:] = 1.0, 1
    sim.restore(sim.state_arrays(), sim.state_numbers())
    assert not slabs.sums.any()
    assert not slabs.fault.any()


def test_a_checkpoint_of_another_version_is_refused():
    sim = simulation(box((1, 1, 1), (2, 2, 2)))
    numbers = {name: value for name, value in sim.state_numbers().items() if name != "balance"} | {"ledger": {}}
    with pytest.raises(UsageError, match="written by another version of pellucid"):
        sim.restore(sim.state_arrays(), numbers)
    arrays = {name: array for name, array in sim.state_arrays().items() if not name.endswith("volume")}
    with pytest.raises(UsageError, match=r"another version of pellucid \(it has no `.*volume`\)"):
        sim.restore(arrays, sim.state_numbers())
    layers = f"{sim.bodies[0].name}/slabs/layers"
    arrays = sim.state_arrays() | {layers: sim.state_arrays()[layers] + 1}
    with pytest.raises(UsageError, match=r"another version of pellucid \(with other slabs\)"):
        sim.restore(arrays, sim.state_numbers())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("basics/sod",), r"'basics/sod' is not a case\.\n    Read one with pellucid.load"),
        (({"title": "x"},), "is not a case"),
    ],
)
def test_what_is_no_case_is_refused(arguments, words, tmp_path):
    with pytest.raises(UsageError, match=words):
        pellucid.run(*arguments)
    with pytest.raises(UsageError, match=words):
        pellucid.run(*arguments, out=tmp_path / "run")
    with pytest.raises(UsageError, match=words):
        pellucid.Simulation(*arguments)
