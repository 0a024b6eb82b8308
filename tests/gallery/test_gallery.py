"""What every case of the gallery must be and do. A new case is picked up by itself."""

import math
import tomllib
from dataclasses import dataclass
from functools import partial

import pytest
from matplotlib.figure import Figure

import pellucid
from pellucid import catalogue
from pellucid.case import load
from pellucid.gallery.gan2011 import piezo_icsi
from pellucid.results.metrics import Metric
from pellucid.results.pictures import bodies_in_space, figures, painter
from pellucid.results.pictures.own import drawn_by_module

WIDTHS = [
    (bodies_in_space, "COLUMNS"),
    (piezo_icsi, "COLUMNS"),
    (piezo_icsi, "FILM_COLUMNS"),
]
"""How many pixels wide pictures in space are."""
LONGEST, LONGEST_SLOW = 3.0, 20.0
"""Durations of quick runs [s], as their cases state them: longer ones are marked slow and full; `pellucid verify` runs all."""
ALWAYS = {"lian2014/sphere-on-membrane"}  # of each paper a case is always run


@dataclass(frozen=True)
class Outcome:
    run: pellucid.Run
    metrics: dict[str, Metric]
    figures: dict[str, Figure]
    """Those of the case's module, as they were drawn for the report."""


def runs_of(names):
    """The cases as parameters, marked by the duration of their quick runs."""
    times = {name: tomllib.loads(catalogue.text(name))["times"]["quick"] for name in names}
    slow = {name for name, seconds in times.items() if seconds > LONGEST and name not in ALWAYS}
    full = {name for name, seconds in times.items() if seconds > LONGEST_SLOW}
    marks = {name: pytest.mark.full if name in full else pytest.mark.slow if name in slow else () for name in names}
    return [pytest.param(name, marks=marks[name]) for name in names]


@pytest.fixture(scope="session", params=runs_of(catalogue.ids()))
def quick(request, tmp_path_factory):
    """The quick variant of a case, run once for all tests."""
    out = tmp_path_factory.mktemp(request.param.replace("/", "-"))
    kept = {}

    def keep(name, figure):
        kept[name] = figure() if callable(figure) else figure
        return kept[name]

    def drawn_and_kept(run, what):
        return {name: partial(keep, name, figure) for name, figure in drawn_by_module(run, what).items()}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(painter, "drawn_by_module", drawn_briefly)
        for module, name in WIDTHS:  # what they show does not depend on it; they would take two thirds of the time of pictures
            patch.setattr(module, name, 150)
        patch.setattr(figures, "drawn_by_module", drawn_and_kept)
        run = pellucid.run(load(request.param).quick_variant(), out=out / "run")
    return Outcome(run, run.metrics, kept)


def drawn_briefly(run, what):
    """What `drawn_by_module` gives; of a film three pictures, since dozens may take as long as the run."""
    found = drawn_by_module(run, what)
    for name, film in found.items() if what == "films" else ():
        times = list(film.times)
        found[name] = film._replace(times=times if len(times) < 3 else [times[0], times[len(times) // 2], times[-1]])
    return found


@pytest.mark.parametrize("name", catalogue.ids())
def test_says_what_it_is(name):
    case = load(name)
    assert case.title
    assert case.source
    assert len(case.description.split()) > 20, "a reader learns from the description what the case shows"
    assert case.quick, "a quick variant"
    assert case.times is not None
    assert case.times.quick <= 600.0
    assert case.quick_variant() != case


@pytest.mark.parametrize("name", catalogue.ids())
def test_measures_itself(name):
    module, case = catalogue.module(name), load(name)
    assert case.checks or callable(getattr(module, "metrics", None))
    assert hasattr(module, "figures") or case.plot or case.picture, "what it shows"


def test_quick_run_is_within_its_tolerances(quick):
    assert quick.metrics
    failed = {name: metric for name, metric in quick.metrics.items() if not metric.passed}
    assert not failed


def test_metrics_have_references(quick):
    for name, metric in quick.metrics.items():
        assert math.isfinite(metric.value), name
        assert math.isfinite(metric.reference), name
        assert metric.error >= 0.0, name
        assert 0.0 < metric.tolerance < 1.0, name
        assert metric.meaning, name


def test_metrics_are_known_before_a_run(quick):
    module = catalogue.module(quick.run.case.id)
    assert set(quick.metrics) <= {*getattr(module, "METRICS", ()), *(check.name for check in quick.run.case.checks)}
    assert set(getattr(module, "ON_KNOWN_MESHES", ())) <= set(quick.metrics)


def test_figures_are_drawn(quick):
    case = quick.run.case
    names = [*quick.figures, *(asked.name for asked in (*case.plot, *case.picture))]
    for name in names:
        assert (quick.run.folder.figures / f"{name}.png").stat().st_size > 0, "drawn for the report"
    for figure in quick.figures.values():
        # pictures in space have no axes, but a scale bar
        assert all(axes.get_xlabel() or axes.get_title() or not axes.lines or not axes.axison for axes in figure.axes)


def test_mass_is_constant(quick):
    case = quick.run.case
    # masses of parts, and those that enter and leave, add up to rounding
    flows = case.inflow or case.outflow or any(body.kind == "fluid-film" for body in case.body)
    assert quick.run.summary["conservation"]["mass"] <= (1e-13 if flows else 0.0)


@pytest.mark.full
@pytest.mark.timeout(0)
@pytest.mark.parametrize("name", catalogue.ids())
def test_full_run_is_within_its_tolerances(name):
    run = pellucid.run(load(name), report=False)
    module = catalogue.module(name)
    known = {*getattr(module, "METRICS", ()), *(check.name for check in run.case.checks)}
    assert set(run.metrics) == known - set(getattr(module, "ON_KNOWN_MESHES", ()))
    assert not {key: metric for key, metric in run.metrics.items() if not metric.passed}
