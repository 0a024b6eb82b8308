"""Diffusion on lines and closed surfaces: exact solutions and their orders, what is conserved, restarts, bad input."""

from math import exp, pi

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.approximants.radial import RADIAL_FUNCTIONS
from pellucid.approximants.radial.functions import PolyharmonicModel
from pellucid.bodies.diffusing_field.weak_forms import on_closed_surface
from pellucid.case import Case, dumps, loads
from pellucid.errors import CaseError, RunStopped
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.references.flows import between_zero_ends
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation.simulation import Simulation

THESIS = {"kind": "polynomial", "zeros": [0, 0.25, 0.5, 1]}
HELD = {"at_lower": 0.0, "at_upper": 0.0}


def line(nodes=21, ends=(), **more):
    domain = {"line": {"lower": 0.0, "upper": 1.0, "nodes": nodes, **dict(ends)}}
    return {"name": "bar", "kind": "diffusing-field", "domain": domain, "material": {"diffusivity": 0.1}} | more


def sphere(refinements=2, **more):
    surface = {"icosphere": {"centre": (1, 2, 3), "radius": 2.0, "refinements": refinements}}
    material = {"diffusivity": 4.0}
    return {"name": "ball", "kind": "diffusing-field", "domain": {"surface": surface}, "material": material} | more


def harmonic(degree, order, **more):
    return {"kind": "spherical-harmonic", "degree": degree, "order": order, "centre": (1, 2, 3)} | more


def case(*bodies, end=0.1, step=1e-3, **more):
    return Case.model_validate({"schema": 1, "title": "t", "time": {"end": end, "step": step}, "body": bodies} | more)


def ended(*bodies, **more):
    """The body of a case at its end."""
    sim = Simulation(case(*bodies, **more), threads=1)
    while not sim.clock.finished(None):
        sim.step()
    return sim.bodies[0]


def bar_error(nodes, radial, step=2e-4):
    body = ended(line(nodes, HELD.items(), initial=[THESIS], radial=radial), step=step)
    x, found = body.arrays["position"][:, 0], body.arrays["concentration"]
    exact = between_zero_ends(lambda y: y * (y - 0.25) * (y - 0.5) * (y - 1.0), 1.0, 0.01, x)
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("kind", list(RADIAL_FUNCTIONS.entries))
@pytest.mark.parametrize(("degree", "order"), [(2, 1.5), (4, 4.0)])
def test_a_bar_converges(kind, degree, order):
    """Between nodes polynomials of even degree leave that order in flows and contents; at the ends one less."""
    coarse, fine = (bar_error(n, {"kind": kind, "degree": degree}) for n in (21, 41))
    assert np.log2(coarse / fine) > order
    if degree == 4:
        assert fine < 3e-5, "the thesis has 6e-5"


def test_the_trapezoidal_rule_is_of_second_order_and_others_of_first():
    def largest(step, alpha):
        """The largest concentration at the end: on the same nodes what differs is of the steps."""
        body = ended(sphere(1, radial={"degree": 2}, initial=[harmonic(2, 0)], alpha=alpha), end=0.4, step=step)
        return float(body.arrays["concentration"].max())

    def order(alpha):
        one, half, quarter = (largest(step, alpha) for step in (0.04, 0.02, 0.01))
        return np.log2((one - half) / (half - quarter))

    assert order(0.5) == pytest.approx(2.0, abs=0.1)
    assert order(0.75) == pytest.approx(1.0, abs=0.15)


def test_what_is_closed_keeps_its_amount():
    for table in (
        line(initial=[THESIS], concentration=0.3),
        sphere(concentration=1.0, initial=[harmonic(2, 1), harmonic(3, -2, amplitude=0.5)]),
    ):
        sim = Simulation(case(table), threads=1)
        body = sim.bodies[0]
        before, uneven = body.field("amount").sum(), np.ptp(body.arrays["concentration"])
        for _ in range(100):
            sim.step()
        assert body.field("amount").sum() == pytest.approx(before, rel=1e-14)
        assert np.ptp(body.arrays["concentration"]) < 0.9 * uneven
        assert sim.budget.conservation() == {"mass": 0.0, "momentum": 0.0, "energy": 0.0}


def test_closed_ends_reflect():
    """cos(πx) fades at π² D, sin does not occur."""
    body = ended(line(41, initial=[{"kind": "polynomial", "zeros": [0.5], "factor": 1.0}]), end=2.0, step=1e-2)
    x, c = body.arrays["position"][:, 0], body.arrays["concentration"]
    waves = pi * np.arange(1, 60, 2)
    series = -np.cos(np.outer(x, waves)) @ (4.0 / waves**2 * np.exp(-0.2 * waves**2))
    assert c == pytest.approx(series, abs=1e-4 * np.abs(series).max())


def test_a_uniform_state_and_a_linear_one_between_held_ends_stay():
    even = ended(line(concentration=0.7))
    assert even.arrays["concentration"] == pytest.approx(0.7, abs=1e-13)
    tilted = ended(line(ends={"at_lower": 1.0, "at_upper": 3.0}.items(), alpha=1.0), end=100.0, step=1.0)
    x = tilted.arrays["position"][:, 0]
    assert tilted.arrays["concentration"] == pytest.approx(1.0 + 2.0 * x, abs=1e-10)
    assert tilted.arrays["concentration"][[0, -1]].tolist() == [1.0, 3.0]


def test_harmonics_fade_at_their_rates():
    """l (l + 1) D/R² = l (l + 1): 6 and 12 per second, at the order that blended functions have on a sphere, 4 at least."""
    errors = []
    for refinements in (2, 3):
        body = ended(sphere(refinements, initial=[harmonic(2, 1), harmonic(3, -2)]), end=0.05, step=5e-4)
        share, errors_here = body.arrays["volume"], []
        for degree, field in ((2, 0), (3, 1)):
            shape = case(sphere(initial=[harmonic(2, 1), harmonic(3, -2)])).body[0].initial[field].at(body.arrays["position"])
            left = share @ (shape * body.arrays["concentration"]) / (share @ shape**2)
            # what the trapezoidal rule makes of the exact rate
            half = 0.5 * 5e-4 * degree * (degree + 1)
            errors_here.append(abs(left / ((1.0 - half) / (1.0 + half)) ** 100 - 1.0))
            assert left == pytest.approx(exp(-degree * (degree + 1) * 0.05), rel=1e-3)
        errors.append(errors_here)
    assert (np.log2(np.array(errors[0]) / errors[1]) > 4.0).all()
    assert max(errors[1]) < 1e-6


def uneven_sphere(refinements):
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).mesh().triangulated()
    spacing = np.sqrt(4.0 * pi / len(vertices))
    vertices = vertices + 0.2 * spacing * np.random.default_rng(1).uniform(-1.0, 1.0, vertices.shape)
    return Triangulation(vertices / np.linalg.norm(vertices, axis=1)[:, None], triangles)


def test_the_surface_operator_is_symmetric_with_the_eigenvalues_of_a_sphere():
    """0, 2, 6, 12 of multiplicity 1, 3, 5, 7, on uneven nodes; its kernel are uniform states."""
    form = on_closed_surface(uneven_sphere(2), PolyharmonicModel())
    content, outflow = form.content.toarray(), form.outflow.toarray()
    assert content == pytest.approx(content.T, abs=1e-15)
    assert outflow == pytest.approx(outflow.T, abs=1e-14)
    assert abs(outflow.sum(axis=0)).max() < 1e-13
    assert content.sum() == pytest.approx(4.0 * pi, rel=1e-4)
    root = np.linalg.inv(np.linalg.cholesky(content))
    found = np.linalg.eigvalsh(root @ outflow @ root.T)
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[1:16] == pytest.approx(np.repeat([2.0, 6.0, 12.0], [3, 5, 7]), rel=2e-4)


def test_wide_windows_solve_the_same_and_the_amount_is_the_integral_for_any():
    for window in (0.25, 0.5, 0.9):
        body = ended(line(41, HELD.items(), initial=[THESIS], window=window))
        x = body.arrays["position"][:, 0]
        exact = between_zero_ends(lambda y: y * (y - 0.25) * (y - 0.5) * (y - 1.0), 1.0, 0.01, x)
        assert body.arrays["concentration"] == pytest.approx(exact, abs=1e-4 * np.abs(exact).max())
        assert body.field("amount").sum() == pytest.approx(-0.0060389, rel=1e-3)


def test_steps_may_differ_in_length():
    """The last one is cut to the end of the case. Rates of the first three waves, up to 9/s: (9 Δt)²/12 is 1e-5."""
    whole, cut = (ended(line(initial=[THESIS], ends=HELD.items()), end=0.1, step=step) for step in (1e-3, 1.3e-3))
    assert cut.arrays["concentration"] == pytest.approx(whole.arrays["concentration"], abs=1e-5 * 0.017)


def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(tmp_path):
    probe = {"name": "amount", "body": "ball", "quantity": "amount", "reduce": "sum"}
    whole_case = case(sphere(1, radial={"degree": 2}, initial=[harmonic(1, 0)], concentration=1.0), probe=[probe])
    assert loads(dumps(whole_case)) == whole_case
    whole = run_case(whole_case, tmp_path / "whole", threads=1, report=False)
    run_case(whole_case, tmp_path / "part", threads=1, until=0.03, report=False)
    gone_on = resume_case(tmp_path / "part", threads=1, report=False)
    for name, column in whole.history.items():
        assert np.array_equal(column, gone_on.history[name]), name
    assert np.array_equal(whole.fields("ball")["concentration"], gone_on.fields("ball")["concentration"])
    assert whole.units["amount"] == "m^3"
    assert whole.history["amount"] == pytest.approx(whole.history["amount"][0], rel=1e-14)
    assert sorted(path.stem for path in (tmp_path / "whole").rglob("*.png")) == []


def test_figures_show_its_concentration_alone(tmp_path):
    run = run_case(case(sphere(1, radial={"degree": 2}, initial=[harmonic(1, 0)])), tmp_path / "ball", threads=1)
    assert [path.stem for path in sorted(run.folder.figures.glob("*.png"))] == ["bodies_load"]
    run = run_case(case(line(initial=[THESIS])), tmp_path / "bar", threads=1)
    assert not list(run.folder.figures.iterdir())
    assert run.cells("bar").lines.tolist() == [[k, k + 1] for k in range(20)]


def test_a_concentration_that_is_no_number_is_named():
    sim = Simulation(case(line(concentration=1.0)), threads=1)
    sim.bodies[0].arrays["concentration"][3] = np.nan
    with pytest.raises(RunStopped, match=r"body `bar` at .* its state is not a finite number"):
        sim.step()


def test_a_closed_sheet_too_thin_for_its_nodes_is_named():
    """A flat box: nodes of the faces have too few neighbours that face the same way."""
    box = {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1), "points": (3, 3, 3)}}
    table = sphere() | {"domain": {"surface": box}}
    with pytest.raises(CaseError, match=r"body.ball.radial[\s\S]*stencil of the node at .* too wide for the curvature"):
        Simulation(case(table), threads=1)


ON_GRID = {"grid": {"lower": (-1, -1, -1), "upper": (2, 2, 2), "cell": 0.5}}
OPEN = {"rectangle": {"corner": (0, 0, 0), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (9, 9)}}


@pytest.mark.parametrize(
    ("table", "more", "words"),
    [
        (
            line(window=1.0),
            {},
            r"window: must be below 1: wider windows do not respond to certain waves of the nodal values",
        ),
        (
            line(window=1.3),
            {},
            r"window: must be below 1: wider windows do not respond to certain waves of the nodal values",
        ),
        (line(window=0.0), {}, r"window[\s\S]*greater than 0"),
        (sphere(window=0.6), {}, r"window: `window` applies to lines"),
        (line(), {"time": {"end": 1.0}}, r"time.step: is missing: body bar does not move, so no stable step"),
        (line(nodes=6), {}, r"domain: a stencil has 7 nodes, but the domain only 6"),
        (sphere(0), {}, r"domain: a stencil has 21 nodes, but the domain only 12"),
        (
            sphere(radial={"neighbours": 12}),
            {},
            r"radial.neighbours: must be at least 15, the number of polynomials of degree 4",
        ),
        (line(radial={"degree": 1}), {}, r"`degree` = 1 is too low[\s\S]*set `degree` to 2 or more"),
        (line(radial={"kind": "gaussian", "shape": 0.1}), {}, r"shape[\s\S]*greater than or equal to 0.5"),
        (line(radial={"kind": "spline"}), {}, r"'polyharmonic', 'thin-plate', 'multiquadric', 'gaussian'"),
        (line(alpha=0.4), {}, r"alpha[\s\S]*greater than or equal to 0.5"),
        (line(material={"diffusivity": 0.0}), {}, r"diffusivity[\s\S]*greater than 0"),
        (line() | {"domain": {"line": {"lower": 1, "upper": 0, "nodes": 9}}}, {}, r"set `upper` above `lower`"),
        (sphere() | {"domain": {"surface": OPEN}}, {}, r"domain.surface: the surface is open"),
        (
            line(initial=[{"kind": "sine-wave", "amplitude": (1, 0, 0), "wave_vector": (1, 0, 0)}]),
            {},
            r"sets `velocity`, but the points of this body do not have it",
        ),
        (sphere(initial=[harmonic(2, 3)]), {}, r"`order` = 3 must be between -`degree` and `degree`, here 2"),
        (line(), ON_GRID, r"kind: bar is fixed and has no contact"),
        (line(), {"steady": {}}, r"steady"),
        (
            line(),
            {"load": [{"kind": "body-force", "body": "bar", "acceleration": (1, 0, 0)}]},
            r"load.0.body: body bar does not",
        ),
        (line(), {"pressure": [{"body": "bar", "value": 1.0}]}, r"pressure.0.body: body bar is not a membrane and has no mesh"),
        (line(), {"motion": [{"name": "go", "body": "bar", "hold": ["x"]}]}, r"motion.0.body: the nodes of body bar are fixed"),
        (line(), {"support": [{"where": "all-nodes"}]}, r"support.0.body: body bar does not move"),
        (line(), {"support": [{"where": "all-nodes", "body": "bar"}]}, r"support.0.body: body bar does not move"),
    ],
)
def test_bad_input_is_explained(table, more, words):
    with pytest.raises(ValidationError, match=words):
        case(table, **more)
