"""The choice of the step, with bodies that only say how fast they are."""

from types import SimpleNamespace

import numpy as np
import pytest
from small_cases import GAS, SOLID, advance, box, case, simulation

from pellucid.case import TimeCase
from pellucid.case.spec import STEP_MARGIN
from pellucid.case.stages import SettleCase
from pellucid.errors import CaseError, RunStopped
from pellucid.running.step_number import of_simulation
from pellucid.simulation.clock import COLLAPSED, Clock
from pellucid.simulation.settling import SettlingClock
from pellucid.step.limit import StepLimit
from pellucid.step.part import StepPart, StepParts


def body(stable, name="block"):
    """A body whose largest stable step is `stable` [s]."""
    totals = SimpleNamespace(rate=1.0 / stable if np.isfinite(stable) else 0.0)
    velocity = np.array([[1.0, 0.0, 0.0], [0.0, -3.0, 4.0]])
    arrays = {"id": np.array([8, 6]), "position": np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5]]), "velocity": velocity}
    return SimpleNamespace(name=name, totals=totals, stored_field=arrays.get)


def ticked(bodies, **settings):
    """Times and steps of a whole run."""
    clock, times, steps = Clock(TimeCase(**settings)), [], []
    while not clock.finished(None):
        clock.advance(clock.next_step(bodies))
        times.append(clock.time)
        steps.append(clock.dt)
        assert len(times) < 10000
    return times, steps


def test_the_most_urgent_body_chooses():
    times, steps = ticked([body(0.5), body(0.1), body(2.0)], end=1.0, courant=0.5)
    assert steps[0] == 0.05
    assert times[-1] == 1.0


@pytest.mark.parametrize("end", [1.0, 0.333, 7.77, 1e-9, 123456.0])
@pytest.mark.parametrize("share", [0.3, 0.0999, 0.1, 1.0, 5.0])
def test_the_last_step_lands_on_the_end_without_a_sliver(end, share):
    times, steps = ticked([body(share * end)], end=end, courant=1.0)
    assert times[-1] == end
    assert min(steps) > 0.49 * max(steps)  # at worst the last two share what is left
    assert max(steps) <= share * end * (1.0 + 1e-9)


@pytest.mark.parametrize(("end", "step", "count"), [(1.0, 0.1, 10), (0.143, 2e-5, 7150), (1.0, 0.3, 4), (1e-4, 5e-10, 200000)])
def test_fixed_steps_are_counted_not_summed(end, step, count):
    if count > 10000:
        clock = Clock(TimeCase(end=end, step=step))
        clock.n_steps = count - 3
        clock.time = clock.n_steps * step
        while not clock.finished(None):
            clock.advance(clock.next_step([body(1.0)]))
        assert (clock.n_steps, clock.time) == (count, end)
        return
    times, steps = ticked([body(1.0)], end=end, step=step)
    assert len(times) == count
    assert times[-1] == end
    assert np.all(np.array(steps[:-1]) == step)
    assert times[:-1] == [n * step for n in range(1, count)]


AROUND = [(0.3 - 1e-11, False, False), (0.3, True, False), (0.3 + 1e-11, True, True)]


@pytest.mark.parametrize(("time", "reached", "passed"), AROUND)
def test_an_end_is_reached_but_for_rounding(time, reached, passed):
    """By the clock as by the results and by a run that goes on: 1e-14 more or less is the same."""
    case = TimeCase(end=0.3)
    for rounded in (time * (1.0 - 5e-14), time, time * (1.0 + 5e-14)):
        clock = Clock(case)
        clock.time = rounded
        assert clock.finished(None) == clock.finished(0.4) == case.reached(rounded) == reached
        assert case.passed(rounded) == passed
        assert clock.finished(0.2)


def test_a_fixed_step_is_checked_before_the_run():
    with pytest.raises(CaseError, match=r"largest stable step is 0.1 s, limited by body `slow`") as caught:
        Clock(TimeCase(end=1.0, step=0.1 * (1.0 + STEP_MARGIN) + 1e-6)).next_step([body(1.0), body(0.1, "slow")])
    assert "time.step" in str(caught.value)
    assert "0.08" in str(caught.value), "a step that would do"
    Clock(TimeCase(end=1.0, step=0.1 * (1.0 + STEP_MARGIN) - 1e-6)).next_step([body(0.1)])


def test_a_fixed_step_is_checked_in_the_run():
    clock = Clock(TimeCase(end=1.0, step=0.1))
    clock.advance(clock.next_step([body(0.1)]))
    with pytest.raises(RunStopped, match=r"step 1, time 0.1 s: .* not stable any more: .* is 0.05 s, limited by body `block`"):
        clock.next_step([body(0.05)])


def test_steps_with_which_no_run_gets_to_the_end_are_refused():
    Clock(TimeCase(end=1.0, courant=1e-11)).next_step([body(0.11)])
    with pytest.raises(CaseError, match=r"is 9e-13 s, which requires more than 1e\+12 steps until time.end = 1 s") as caught:
        Clock(TimeCase(end=1.0, courant=1e-11)).next_step([body(0.09)])
    assert "time.courant = 1e-11" in str(caught.value)


def test_a_collapsed_step_stops():
    clock = Clock(TimeCase(end=1.0, courant=0.5))
    clock.advance(clock.next_step([body(0.1)]))
    clock.next_step([body(0.1 * COLLAPSED * 1.01)])
    words = r"by body `block`, has decreased to 4.95e-08 s.* fastest point: number 6 of body `block` at \(1, 2, 0.5\) m, 5 m/s"
    with pytest.raises(RunStopped, match=words) as stopped:
        clock.next_step([body(0.1 * COLLAPSED * 0.99)])
    assert stopped.value.place == {"body": "block", "point": 6, "position": [1.0, 2.0, 0.5]}


def test_without_any_signal_a_step_may_take_all_the_time():
    times, _ = ticked([body(np.inf)], end=3.0)
    assert times == [3.0]


def test_until_stops_early_and_never_late():
    clock = Clock(TimeCase(end=1.0, step=0.1))
    while not clock.finished(0.25):
        clock.advance(clock.next_step([body(1.0)]))
    assert clock.n_steps == 3
    clock.n_steps, clock.time = 10, 1.0
    assert clock.finished(5.0)


def test_a_restored_clock_goes_on():
    clock = Clock(TimeCase(end=1.0, courant=0.37))
    for stable in (0.1, 0.07, 0.2):
        clock.advance(clock.next_step([body(stable)]))
    other = Clock(clock.case)
    other.restore(clock.state_numbers(), clock.state_arrays())
    assert vars(other) == vars(clock)


class Gap(StepPart):
    """A part that requires steps that resolve a gap."""

    def __init__(self, step):
        self.step = step

    def step_limit(self):
        return StepLimit(self.step, "spring", "the gap of the electrodes")


def limited(stable, **settings):
    """A clock whose stable step a part limits to `stable` [s]."""
    return Clock(TimeCase(end=1.0, **settings), parts=StepParts([StepPart(), Gap(stable)]))


@pytest.mark.parametrize("kind", ["run", "settling"])
def test_a_part_limits_the_step_as_bodies_do(kind):
    clock = limited(0.01, courant=0.5)
    clock = clock if kind == "run" else SettlingClock(SettleCase(), clock, [])
    assert clock.next_step([body(0.1), body(np.inf)]) == 0.5 * 0.01
    assert clock.next_step([body(np.inf)]) == 0.5 * 0.01
    assert clock.next_step([body(0.005)]) == 0.5 * 0.005
    assert clock.limit([body(0.1)]) == (StepLimit(0.01, "spring", "the gap of the electrodes"), "")


def test_a_step_that_a_part_does_not_allow_is_refused_with_its_reason():
    with pytest.raises(CaseError, match=r"step is 0.01 s, limited by the gap of the electrodes\n.*at most 0.008 s"):
        limited(0.01, step=0.02).next_step([body(0.1)])
    with pytest.raises(CaseError, match="limited by the gap of the electrodes, is 4e-14 s, which requires more than"):
        limited(1e-13, courant=0.4).next_step([body(0.1)])
    clock = limited(0.01, courant=1.0)
    clock.advance(clock.next_step([body(0.1)]))
    clock.parts.of(Gap)[0].step = 1e-9
    with pytest.raises(RunStopped, match=r"limited by the gap of the electrodes, has decreased to 1e-09 s") as stopped:
        clock.next_step([body(0.1), body(0.1, "other")])
    assert stopped.value.place["body"] == "block", "of the fastest point"


def test_a_run_takes_the_steps_that_its_forecast_states_for_a_part():
    sim = simulation(box((1, 1, 1), (2, 2, 2), GAS), counts=(4, 4, 4), end=1e-3)
    sim.parts.add([Gap(1e-5)])
    found = of_simulation(sim)
    assert found.why == "limited by the gap of the electrodes; time.courant = 0.4"
    assert advance(sim, 1).dt == found.step == 0.4 * 1e-5


# the bounds of bodies


def stable_step(material, velocity=(0.0, 0.0, 0.0)):
    sim = simulation(box((1, 1, 1), (2, 2, 2), material, velocity=velocity), counts=(8, 8, 8), cell=0.5, courant=1.0, end=1e9)
    return sim.clock.next_step(sim.bodies)


def test_courant_bound():
    """h / (c + |v|)."""
    assert stable_step(GAS, (3.0, 0.0, -4.0)) == pytest.approx(0.5 / (np.sqrt(1.4) + 5.0), rel=1e-12)
    modulus = 1e4 * 0.7 / (1.3 * 0.4)  # E (1-ν) / (1+ν)(1-2ν)
    assert stable_step(SOLID, (0.0, 2.0, 0.0)) == pytest.approx(0.5 / (np.sqrt(modulus / 1000.0) + 2.0), rel=1e-12)


def test_diffusive_bound():
    """ρ h² / (2 (2μ + λ)), with Stokes' λ = -2μ/3."""
    assert stable_step(GAS | {"viscosity": 50.0}) == pytest.approx(0.25 / (2.0 * 4.0 / 3.0 * 50.0), rel=1e-12)


def test_artificial_viscosity_tightens_the_bound():
    """In compression the signal speed is Q + sqrt(Q² + a²), Q = c₁ a + c₀ h |tr D|."""
    wave = {"amplitude": (-0.4, 0, 0), "wave_vector": (1.0, 0, 0), "phase": -2.0}  # runs together about x = 2
    steps = {}
    for name, av in (("without", {}), ("with", {"quadratic": 2.0, "linear": 1.0})):
        gas = box((1, 1, 1), (3, 3, 3), GAS | {"artificial_viscosity": av}, velocity_wave=wave)
        sim = advance(simulation(gas, counts=(8, 8, 8), cell=0.5, courant=0.05, end=1e9), 1)
        steps[name] = sim.clock.next_step(sim.bodies)
    a, rate = np.sqrt(1.4), 0.4
    Q = a + 2.0 * 0.5 * rate
    # gas that hardly changed in a twentieth of a step; the grid smooths the wave's slope
    assert steps["with"] == pytest.approx(0.05 * 0.5 / (Q + np.sqrt(Q * Q + a * a)), rel=0.1)
    assert steps["without"] > 2.0 * steps["with"]


def test_an_unstable_fixed_step_is_an_error_of_the_case():
    with pytest.raises(ValueError, match="largest stable step"):
        case(box((1, 1, 1), (2, 2, 2), GAS), step=2.0)
    # a rotation is no part of the case's own check, which knows no points; the set-up finds it
    spinning = box((1, 1, 1), (3, 3, 3), GAS, angular_velocity=(0, 0, 40.0))
    with pytest.raises(CaseError, match=r"largest stable step is .* s, limited by body `block`"):
        simulation(spinning, step=0.5)


@pytest.mark.parametrize(("before", "after"), [(None, 1e-2), (1e-2, 5e-3), (5e-3, 1e-2), (1e-2, None)])
def test_a_run_goes_on_with_another_step_where_it_is(before, after):
    first = Clock(TimeCase(end=1.0, step=before))
    for _ in range(7):
        first.advance(first.next_step([body(0.04)]))
    clock, times = Clock(TimeCase(end=1.0, step=after)), []
    clock.restore(first.state_numbers(), {})
    assert clock.time == first.time
    while not clock.finished(None):
        step = clock.next_step([body(0.04)])
        clock.advance(step)
        times.append(clock.time)
    assert np.all(np.diff([first.time, *times]) > 0.0)
    assert times[0] == pytest.approx(first.time + (after or 0.04 * clock.case.courant))
    assert times[-1] == 1.0
