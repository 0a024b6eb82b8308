"""Kernels that are known before they are compiled, and compiled elsewhere."""

import numba
import pytest

from pellucid.case import dumps, load, loads
from pellucid.compilation import ahead
from pellucid.jit import cache_folder
from pellucid.jit.registry import kernels
from pellucid.system.processes import Helper, helped

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


def foretold(text):
    """What a case calls, as it is known without a kernel that runs."""
    return [(of.py_func.__module__, of.py_func.__name__, str(types)) for of, types in ahead.kernels_of(loads(text))]


def called(text):
    """What a case calls."""
    from pellucid.simulation.simulation import Simulation

    simulation = Simulation(loads(text), threads=1)
    simulation.step()
    for body in simulation.bodies:
        for name in body.field_names:
            body.field(name)
    from_python = [compiled for compiled in kernels.values() if "_compile_for_args" not in vars(compiled)]
    return [(of.py_func.__module__, of.py_func.__name__, str(types)) for of in from_python for types in of.signatures]


def foreteller():
    return foretold


def caller():
    return called


@pytest.mark.parametrize("name", ["basics/elastic-wave", "basics/colliding-discs", "gan2011/piezo-icsi"])
def test_all_kernels_of_a_step_are_foretold(name):
    text = dumps(load(name).quick_variant())
    helpers = [Helper(foreteller), Helper(caller)]
    with helped(helpers):
        before, after = (helper.ask(text) for helper in helpers)
    assert len(before) == len(set(before)) > 5
    # whether points must be moved when they are first sorted is not known ahead
    assert set(after) <= set(before)
    assert {name for _, name, _ in set(before) - set(after)} <= {"_reorder_rows"}


def test_the_last_kernel_comes_into_the_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    text = dumps(load("basics/elastic-wave").quick_variant())
    helper = Helper(foreteller)
    with helped([helper]):
        *_, (module, name, _) = helper.ask(text)
    helper = Helper(ahead.compile_from_the_end, text, 0, 1000)  # so many that only the last is left
    with helped([helper]):
        assert helper._process.wait(200) == 0
    assert list((cache_folder() / module).glob(f"{name}-*.nbc"))


def test_other_processes_begin_once_and_end_with_the_block(monkeypatch):
    begun = []

    class Counted(Helper):
        def __init__(self, make, *arguments):
            super().__init__(make, *arguments)
            begun.append(self)

    monkeypatch.setattr(ahead, "Helper", Counted)
    monkeypatch.setattr(ahead, "free_cores", lambda: 2)
    with ahead.compiled_ahead(load("basics/elastic-wave")) as begin:
        assert not begun
        begin()
        begin()
        assert len(begun) == 2
    assert all(helper._process.returncode is not None for helper in begun)


@pytest.mark.parametrize("lacking", ["cores", "memory"])
def test_nothing_begins_where_cores_or_memory_are_scarce(monkeypatch, lacking):
    monkeypatch.setattr(ahead, "Helper", lambda *arguments: pytest.fail("a process began"))
    monkeypatch.setattr(ahead, "free_cores", lambda: 0 if lacking == "cores" else 4)
    monkeypatch.setattr(ahead, "MOST_MEMORY", 0.0 if lacking == "memory" else 1.0)
    with ahead.compiled_ahead(load("basics/elastic-wave")) as begin:
        begin()
