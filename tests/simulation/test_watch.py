"""From when on the energy balance is judged, and what is advised; fluids of more volume than the grid."""

from types import SimpleNamespace

import pytest
from small_cases import GAS, SLIP, box, past_a_disc, simulation

from pellucid.case.spec import EnergyCase
from pellucid.energy import FIRST_JUDGED
from pellucid.errors import RunStopped
from pellucid.simulation.watch import Watch


def clock(n_steps, sums=False, last=False):
    known = {"against_energy_error": None, "is_adjusting": False, "adds_works_of_load_steps": sums}
    return SimpleNamespace(n_steps=n_steps, finished=lambda until: last, progress=lambda: 1.0, **known)


def watch_of(own_steps=False, has_grid=True):
    grid, time = ("a grid" if has_grid else None), SimpleNamespace(transfer="flip")
    return Watch(SimpleNamespace(energy=EnergyCase(), grid_or_none=grid, time=time), own_steps)


def half_lost(moved, made=0.0):
    """A balance that lacks half of what moved, with 1 J stored."""
    lost = {"transfer": 0.0, "time_integration": -0.5 * moved, "made": made}
    return SimpleNamespace(energy_error=lambda: -0.5, energy_scale=moved, stored=1.0, **lost)


@pytest.mark.parametrize(
    ("has_grid", "advice"),
    [
        (True, "Use a smaller time step or a finer grid, or increase energy.stop"),
        (False, "Use a smaller time step, or increase energy.stop"),
    ],
)
def test_a_loss_stops_a_run_after_its_first_steps_with_an_advice_that_applies(has_grid, advice):
    watch = watch_of(has_grid=has_grid)
    watch.energy(half_lost(5.0), clock(FIRST_JUDGED - 1), [])
    with pytest.raises(RunStopped, match=advice):
        watch.energy(half_lost(5.0), clock(FIRST_JUDGED), [])


def test_works_of_few_load_steps_warn_at_the_end_and_stop_nothing():
    watch = watch_of()
    watch.energy(half_lost(5.0), clock(FIRST_JUDGED, sums=True), [])
    with pytest.warns(UserWarning, match=r"by 50 %.* Set a larger steady\.load_steps"):
        watch.energy(half_lost(5.0), clock(3, sums=True, last=True), [])


def test_what_contact_and_transfers_made_is_named():
    watch = watch_of()
    with pytest.raises(RunStopped, match=r"time integration -2.5 J, added by contact and transfers 0.25 J\)"):
        watch.energy(half_lost(5.0, made=0.25), clock(FIRST_JUDGED), [])


def test_bodies_with_steps_of_their_own_are_judged_from_the_first_on():
    watch = watch_of(own_steps=True, has_grid=False)
    with pytest.raises(RunStopped, match="Use a lower `accuracy` or more nodes, or increase"):
        watch.energy(half_lost(5.0), clock(1), [])


def test_a_squeezed_liquid_is_warned_of_with_a_speed_that_helps():
    liquid = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 2.0, "exponent": 1.0}}
    sim = simulation(box((0, 0, 0), (2, 2, 0), liquid, (2, 2, 1), name="water"), counts=(2, 2, 1), support=SLIP[:4])
    body = sim.bodies[0]
    body.arrays["volume"] *= 0.98
    assert body.state_warning() is None
    body.arrays["volume"] *= 0.96 / 0.98
    told = body.state_warning()
    assert told.startswith(
        "body `water`: it is compressed by 4 % of its volume; if this is not intended, increase eos.sound_speed"
    )
    assert told.endswith("with 5.2 m/s it is 0.6 %")


@pytest.mark.parametrize(("transfer", "advice"), [("flip", ', or set time.transfer = "apic"; see'), ("apic", "; see")])
def test_more_fluid_than_the_grid_holds_is_warned_of(transfer, advice):
    gas = box((0, 0, 0), (2, 2, 0), GAS, (2, 2, 1), name="gas")
    sim = simulation(gas, counts=(2, 2, 1), support=SLIP[:4], thickness=0.1, transfer=transfer)
    sim.bodies[0].arrays["volume"] *= 1.009
    sim._watch.volumes(sim._on_grid, sim.clock)
    sim.bodies[0].arrays["volume"] *= 1.041
    text = f"volume of the points of gas is 5 % larger than the grid.*Add cell_pressure = true to the body{advice}"
    with pytest.warns(UserWarning, match=text):
        sim._watch.volumes(sim._on_grid, sim.clock)


@pytest.mark.parametrize("even_points", [False, True])
def test_gaps_in_a_liquid_are_named(even_points, recwarn):
    """Points leave gaps behind a disc in a slow flow, unless they are kept even."""
    sim = past_a_disc(12.0, even_points=even_points)
    while not sim.clock.finished(None):
        sim.step()
    found = [str(one.message) for one in recwarn if "contain no points" in str(one.message)]
    assert len(found) == (0 if even_points else 1)
    if found:
        settings = "body.water.cell_pressure = true and body.water.material.even_points = true"
        assert f"cells inside water contain no points, so the flow is wrong there. Set {settings}" in found[0]


BETTER, EVEN = 'grid.functions = "quadratic-bspline"', "body.water.material.even_points = true"


@pytest.mark.parametrize(
    ("functions", "transfer", "even", "has_membrane", "advice"),
    [
        ("quadratic-bspline", "apic", False, False, EVEN),
        ("quadratic-bspline", "flip", False, False, f'time.transfer = "apic" and {EVEN}'),
        ("trilinear", "apic", False, False, f"{BETTER} and {EVEN}"),
        ("gimp", "flip", False, False, f'{BETTER} and time.transfer = "apic" and {EVEN}'),
        ("gimp", "apic", True, False, BETTER),
        ("quadratic-bspline", "apic", True, False, ""),
        ("trilinear", "flip", False, True, BETTER),
        ("quadratic-bspline", "apic", False, True, ""),
    ],
)
def test_the_advice_about_gaps_can_be_followed(functions, transfer, even, has_membrane, advice, monkeypatch):
    """Even points need APIC and are refused beside membranes; with other functions than B-splines flow is still too fast."""
    material = {"kind": "fluid", "density": 1.0, "even_points": even, "eos": {"kind": "tait", "sound_speed": 10.0}}
    surface = {"rectangle": {"corner": [1, 1, 1], "first_edge": [2, 0, 0], "second_edge": [0, 2, 0], "points": [5, 5]}}
    skin = {"kind": "linear-membrane", "density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.3}
    sheet = {"kind": "membrane-points", "name": "sheet", "surface": surface, "thickness": 0.01, "material": skin}
    water = box((0, 0, 0), (4, 4, 4), material, (2, 2, 2), name="water")
    sim = simulation(water, *([sheet] if has_membrane else []), functions=functions, transfer=transfer, support=SLIP)
    monkeypatch.setattr("pellucid.simulation.watch.share_of_gaps", lambda field, bodies: 0.05)
    wrong = "5 % of the cells inside water contain no points, so the flow is wrong there"
    with pytest.warns(UserWarning, match=wrong) as caught:
        sim._watch.gaps(sim._on_grid, sim.clock)
    smaller = f"{advice}, or a smaller grid.cell" if advice else "a smaller grid.cell"
    assert str(caught[0].message).endswith(f"{wrong}. Set {smaller}.")


def test_a_free_surface_has_no_gaps(recwarn):
    """Splashing water leaves cells without points too, but does not fill its space."""
    water = {"kind": "fluid", "density": 1000.0, "viscosity": 1e-3, "eos": {"kind": "tait", "sound_speed": 20.0}}
    body = box((0, 0, 0), (0.4, 0.8, 0.1), water, (2, 2, 1))
    sim = simulation(body, counts=(16, 10, 1), cell=0.1, gravity=(0, -9.81, 0), support=SLIP[:4], end=0.8)
    while not sim.clock.finished(None):
        sim.step()
    assert not [one for one in recwarn if "contain no points" in str(one.message)]
