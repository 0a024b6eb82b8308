"""Films whose nodes are led along the normal."""

import numpy as np
import pytest
from films import case, ran
from small_cases import RATE_SOLID, box
from small_cases import case as blocks

import pellucid
from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

CIRCLE = "ellipse = { radius = 1, nodes = 20 }"
SPHERE = "spheroid = { radius = 1, nodes = 21 }"
LOOP = "surface = { icosphere = { centre = [0, 0, 0], radius = 1, refinements = 2 } }"
CAP = "part = { box = { lower = [-2, -2, 0.75], upper = [2, 2, 2] } }"
DRAG = "drag = { normal = 1, tangential = 1 }"
ETA = 3.0  # 2 μ + λ


def led(signal='kind = "steady", velocity = 0.2', part="", name="swell"):
    return f"""
[[motion]]
name = "{name}"
body = "film"
displacement = {{ normal = {{ {signal} }} }}
{part}
"""


@pytest.mark.parametrize(
    ("shape", "more", "off"),
    [
        (CIRCLE, "", 1e-13),
        (CIRCLE, DRAG, 1e-13),
        (SPHERE, "", 1e-9),  # of the interpolation, fourth order in the distance of nodes
        (LOOP, "", 6e-4),  # of normals by triangles and of the area, of second order: a hundredth of (edge / radius)²
        (LOOP, 'interpolation = "radial"', 6e-5),
    ],
)
def test_a_film_that_is_led_everywhere_grows_as_told(shape, more, off):
    """R = 1 + V t and a density of m/A; without drag too, though a sphere and a circle could turn."""
    of = case(shape, 0.4, 1.0, "", more, led(), 0.2)
    simulation, film = ran(of)
    radii, dimension = film.field("distance"), 1 if shape == CIRCLE else 2
    start = Simulation(of).bodies[0].field("distance").mean()
    assert radii == pytest.approx(start + 0.08, abs=off)
    o = film.geometry.operators(film.arrays["x"])
    assert film.field("areal_density") * o.area.sum() == pytest.approx(film.mass, rel=1e-12 if shape == CIRCLE else 1e-3)
    assert film.field("areal_density").mean() == pytest.approx(radii.mean() ** -dimension, rel=1e-3)
    spin = np.cross(film.arrays["position"], film.arrays["velocity"]).mean(axis=0)
    assert np.abs(spin).max() < off, "it does not turn"
    assert abs(simulation.budget.conservation()["mass"]) < 1e-13


def test_its_work_is_what_is_stored_and_dissipated_to_second_order_in_the_step():
    """Of a circle ∫ 2πR η (V/R)² dt = 2π η V ln(R/R₀), and the stored energy at ρ = 1/R."""
    errors, works = [], []
    for step in (0.5, 0.25, 0.125):
        simulation, _ = ran(case(CIRCLE, 1.0, 1.0, "", "density = 1.2", led(), step))
        errors.append(abs(simulation.budget.conservation()["energy"]))
        works.append(simulation.budget.energies()["motion_work"])
    assert errors[0] > 2.5 * errors[1] > 6.0 * errors[2]
    heat = 2.0 * np.pi * ETA * 0.2 * np.log(1.2)
    compressed = 2.0 * np.pi * 1.2 * (np.log(1.2) + 1.0 / 1.2 - 1.0)  # of the mass, ∫ p/ρ² dρ from 1 to 1.2; at the end 0
    assert works[-1] == pytest.approx(heat - compressed, rel=1e-4)


def test_it_follows_a_smooth_history_to_its_end_exactly():
    signal = 'kind = "ramp", distance = -0.1, duration = 0.3'
    _, film = ran(case(CIRCLE, 0.4, 1.0, "", "", led(signal), 0.1))
    assert film.field("distance") == pytest.approx(0.9, abs=1e-13)
    assert np.abs(film.arrays["v"]).max() < 1e-13, "it is at rest after the ramp"


@pytest.mark.parametrize("shape", [SPHERE, LOOP])
def test_a_part_of_a_film_is_led_and_the_rest_follows(shape, tmp_path):
    probe = """
[[probe]]
name = "force"
quantity = "reaction"
condition = "push"
component = "z"

[[probe]]
name = "across"
quantity = "reaction"
condition = "push"
component = "x"
"""
    signal = 'kind = "steady", velocity = -0.3'
    of = case(shape, 0.1, 1.0, "", DRAG, led(signal, CAP, "push") + probe, 0.01)
    run = pellucid.run(of, out=tmp_path / "run", report=False)
    _, film = ran(of)
    start = Simulation(of).bodies[0].arrays["position"][:, 2]
    top, low = film.arrays["position"][:, 2].max(), film.arrays["position"][:, 2].min()
    # what nodes of a Loop surface must do is known from the step before, and of the first step to 1 %
    assert top == pytest.approx(start.max() - 0.03, abs=1e-5 if shape == SPHERE else 5e-5)
    assert -1.01 < low < -0.99, "what is not led stays where the drag holds it"
    o = film.geometry.operators(film.arrays["x"])
    moved = np.einsum("eqmd,emd->eqd", o.value, film.arrays["v"][film.geometry.nodes])[..., -1]
    drag = float(np.sum(o.area * moved))  # nothing else acts from outside; that of the last step, the force is a mean over more
    assert run.history["force"][-1] == pytest.approx(drag, rel=0.02)
    assert run.history["across"][-1] == pytest.approx(0.0, abs=1e-5)
    assert run.history["motion_work"][-1] > 0.0
    assert abs(run.history["energy_error"][-1]) < 1e-4


def test_a_led_film_goes_on_from_its_checkpoint_bit_for_bit(tmp_path):
    of = case(LOOP.replace("= 2", "= 1"), 0.2, 1.0, "", DRAG, led(part=CAP))
    whole = pellucid.run(of, out=tmp_path / "whole", report=False)
    pellucid.run(of, out=tmp_path / "part", until=0.1, report=False)
    resumed = resume_case(tmp_path / "part", report=False)
    assert np.array_equal(whole.fields("film")["position"], resumed.fields("film")["position"])


@pytest.mark.parametrize(
    ("more", "extra", "message"),
    [
        ("", led(part="part = { box = { lower = [5, 5, 5], upper = [6, 6, 6] } }"), r"no point of body film lies in it"),
        ("volume = {}", led(), r"prescribes all nodes of film film, whose volume is already prescribed.*remove `volume`"),
        ('area = "kept"', led(), r"whose area is already prescribed.*remove `area`"),
        ("", led() + "hold = ['x']", r"x cannot be combined with `normal`, .*remove it"),
        (
            "",
            led().replace("normal =", "x ="),
            r"cannot follow a prescribed motion along the axes.*displacement along the `normal`",
        ),
        ("", led(signal='kind = "steady"'), r"velocity"),
    ],
)
def test_what_cannot_be_led_is_refused(more, extra, message):
    with pytest.raises(CaseError, match=r"(?s)" + message):
        case(more=more, loads_of=extra)


def test_nodes_that_a_support_holds_cannot_be_led_too():
    support = """
[[support]]
name = "belt"
body = "film"
where = { box = { lower = [0.9, -2, -2], upper = [2, 2, 2] } }
fix = ["x"]
"""
    with pytest.raises(
        CaseError, match=r"(?s)support `belt` constrains \d+ of the nodes of film film that follow this motion.*not overlap"
    ):
        ran(case(loads_of=led() + support))


def test_nodes_follow_one_motion():
    with pytest.raises(CaseError, match="already follow the motion swell"):
        ran(case(loads_of=led() + led(name="more")))


def test_two_motions_that_lead_all_nodes_leave_no_volume_to_keep():
    upper = led(part="part = { box = { lower = [-2, 0, -1], upper = [2, 2, 1] } }", name="upper")
    lower = led(part="part = { box = { lower = [-2, -2, -1], upper = [2, -1e-6, 1] } }", name="lower")
    with pytest.raises(CaseError, match="prescribes all nodes of film film, whose volume is already prescribed"):
        ran(case(more="volume = {}", loads_of=upper + lower))


def test_only_films_are_led_along_a_normal():
    motion = {"name": "swell", "body": "block", "displacement": {"normal": {"kind": "steady", "velocity": 1.0}}}
    table = blocks(box((1, 1, 1), (3, 3, 3), RATE_SOLID)).to_data() | {"motion": [motion]}
    with pytest.raises(ValueError, match="body block is not a fluid film"):
        Case.model_validate(table)
