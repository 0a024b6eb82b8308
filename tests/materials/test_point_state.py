"""States of points and their arrays: declared once, loaded and stored as they are, also by laws of users."""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from samples import MATERIALS

from pellucid.jit import kernel
from pellucid.materials.law import stored_energy, update
from pellucid.materials.point_state import in_arrays, initial_arrays, load, point_state, store
from pellucid.state import FIELDS, Field
from pellucid.tensors import Symmetric

STATES = {type(material.initial_state()): material.initial_state() for material in MATERIALS.values()}
every_state = pytest.mark.parametrize("state", STATES.values(), ids=[kind.__name__ for kind in STATES])


def numbered(state, start):
    """A state of the same type whose components are start, start + 1, ..."""
    values = []
    for value in state:
        n = np.size(value)
        values.append(tuple(float(start + k) for k in range(n)) if isinstance(value, tuple) else float(start))
        start += n
    return type(state)(*values)


@every_state
def test_points_begin_in_the_initial_state(state):
    arrays = initial_arrays(state, 3)
    assert tuple(arrays) == state._fields
    carried = in_arrays(state, arrays)
    for p in range(3):
        assert load(carried, p) == state
    for name, array in arrays.items():
        assert array.dtype == float
        assert array.shape == ((3,) if FIELDS[name].components == 1 else (3, FIELDS[name].components))


@every_state
def test_what_is_stored_is_loaded(state):
    """Each component in its place, and no other point is touched."""
    carried = in_arrays(state, initial_arrays(state, 3))
    store(carried, 1, numbered(state, 7))
    assert [load(carried, p) for p in range(3)] == [state, numbered(state, 7), state]
    flat = np.concatenate([np.ravel(array[1]) for array in carried])
    assert flat.tolist() == list(range(7, 7 + len(flat)))


@kernel()
def stepped(law, carried, density, L, dt, length):
    energy = 0.0
    for p in range(len(density)):
        state = update(law, load(carried, p), density[p], L, dt, length)
        store(carried, p, state)
        energy += stored_energy(law, state, density[p])
    return energy


@pytest.mark.parametrize("name", ["user-kelvin-voigt", "standard-linear"])
def test_compiled_loops_carry_the_state_of_a_user(name):
    material, L = MATERIALS[name], (0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    law, density = material.law(), np.full(2, material.density)
    carried = in_arrays(material.initial_state(), initial_arrays(material.initial_state(), 2))
    state = material.initial_state()
    for _ in range(3):
        found = stepped(law, carried, density, L, 0.01, 0.1)
        state = update(law, state, material.density, L, 0.01, 0.1)
    # fused multiplications round differently
    for p in range(2):
        for one, other in zip(load(carried, p), state, strict=True):
            assert one == pytest.approx(other, rel=1e-12, abs=1e-9)
    assert found == pytest.approx(2.0 * stored_energy(law, state, material.density), rel=1e-12)


def test_a_new_field_has_the_unit_and_meaning_that_it_was_declared_with():
    assert FIELDS["viscous_work"] == Field(1, "J/kg", "work that the viscosity turned into heat")
    assert FIELDS["overstress"] == Field(6, "Pa", "stress of the Maxwell branch")


def test_states_may_share_a_field():
    @point_state(overstress=("Pa", "stress of the Maxwell branch"))
    class Same(NamedTuple):
        stress: Symmetric
        overstress: Symmetric

    same = Same((1.0,) * 6, (2.0,) * 6)
    assert load(in_arrays(same, initial_arrays(same, 1)), 0) == same


class NoStress(NamedTuple):
    strain_energy: float


class FewStress(NamedTuple):
    stress: tuple[float, float]


class Unknown(NamedTuple):
    stress: Symmetric
    history: float


class Taken(NamedTuple):
    stress: Symmetric
    volume: float


class Wrong(NamedTuple):
    stress: Symmetric
    deformation_gradient: Symmetric


class Open(NamedTuple):
    stress: Symmetric
    history: tuple[float, ...]


class Whole(NamedTuple):
    stress: Symmetric
    history: int


@pytest.mark.parametrize(
    ("state", "own", "text"),
    [
        (NoStress, {}, "NoStress has no `stress: Symmetric`"),
        (FewStress, {}, "FewStress has no `stress: Symmetric`"),
        (Unknown, {}, r'Unknown.history: declare it with @point_state\(history=\("unit", "meaning"\)\)'),
        (Unknown, {"histroy": ("1", "x")}, "Unknown has no field `histroy`"),
        (Unknown, {"history": ("J", "x"), "more": ("1", "x")}, "Unknown has no field `more`"),
        (
            Taken,
            {"volume": ("m^3", "of the pores")},
            r"Taken.volume: a field of this name exists \(current volume\)",
        ),
        (Wrong, {}, "Wrong.deformation_gradient has 9 components, not 6"),
        (Open, {}, "Open.history must be a float, or a tuple of two or more floats whose number is fixed"),
        (Whole, {}, "Whole.history must be a float"),
    ],
)
def test_states_that_cannot_be_carried(state, own, text):
    before = dict(FIELDS)
    with pytest.raises(TypeError, match=text):
        point_state(**own)(state)
    assert before == FIELDS


SCRIPT = """
import numpy as np
from samples import MATERIALS
from test_point_state import stepped
from pellucid.materials.point_state import in_arrays, initial_arrays

for name in ("user-kelvin-voigt", "standard-linear"):
    material = MATERIALS[name]
    state = material.initial_state()
    carried = in_arrays(state, initial_arrays(state, 2))
    stepped(material.law(), carried, np.full(2, material.density), (0.1,) * 9, 0.01, 0.1)
print(sum(stepped.stats.cache_hits.values()), sum(stepped.stats.cache_misses.values()))
"""


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_a_second_process_need_not_compile_a_user_s_law_and_state(tmp_path):
    """Laws and states of a module; what is written for a state does not keep compiled loops from the disk."""
    here = Path(__file__).parent
    places = [str(here), str(here.parent), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(places)}
    found = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
        ).stdout.split()
        for _ in range(2)
    ]
    assert found == [["0", "2"], ["2", "0"]]
