"""Searches for equilibria that a signal ends, and runs that go on from the last equilibrium."""

import pytest

from pellucid.errors import Interrupted
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation.simulation import Simulation


def assert_goes_on_after_a_signal(case, folder, monkeypatch, owner, name, signalled):
    """A run that is interrupted while the method `name` of the class `owner` is `signalled`, and resumed, has the history of a
    run without interruption, which is returned in bytes."""
    run_case(case, folder / "whole", report=False)
    with monkeypatch.context() as patched:
        patched.setattr(owner, name, signalled)
        with pytest.raises(Interrupted):
            run_case(case, folder / "part", report=False)
    resume_case(folder / "part", report=False)
    one, other = ((folder / kind / "history.csv").read_bytes() for kind in ("part", "whole"))
    assert one == other
    return one


def go_on(simulation):
    """Compute a run to its end."""
    while not simulation.clock.finished(None):
        simulation.step()


def whole_and_ended(case, threads=1):
    """Return two simulations after the first load step; the search of the second one is ended in the second load step, after
    offsets of contact and tool were changed."""
    whole, ended = Simulation(case, threads=1), Simulation(case, threads=threads)
    for simulation in (whole, ended):
        while simulation.time == 0.0:
            simulation.step()
    calls = 0

    def interrupt():
        nonlocal calls
        calls += 1
        if calls == 25:
            raise Interrupted("a signal")

    ended.clock.on_the_way = interrupt
    with pytest.raises(Interrupted):
        go_on(ended)
    return whole, ended


def resumed_from(ended, case, threads=1):
    """Return a simulation that is restored from the state of another one."""
    resumed = Simulation(case, threads=threads)
    resumed.restore({name: array.copy() for name, array in ended.state_arrays().items()}, ended.state_numbers())
    return resumed
