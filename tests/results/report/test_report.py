import base64
import re
import sys
import types

import pytest
from free_flight import FakeSimulation, fake_module, free_flight
from typer.testing import CliRunner

from pellucid.case import load
from pellucid.cli import app
from pellucid.errors import UsageError
from pellucid.results.metrics import Metric
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.style import new_figure, pretty
from pellucid.results.report.report import number, write_report
from pellucid.results.storage.run import Run
from pellucid.running.launch import run_case
from pellucid.studies.verification import verify

METRICS = {
    "front": Metric(2.5, 2.52, 0.008, 0.01, "m", "where the front is"),
    "loss<0": Metric(float("nan"), 0.0, 0.3, 0.1),
}

CAPTIONS = {"front_of_the_gas": "How far the gas < came.", "flight": "How the gas flies."}


def _figure(run):
    figure = new_figure(4.0, 2.0)
    figure.subplots().plot(run.history["time"], run.history["front"])
    titled = new_figure(4.0, 2.0)
    titled.suptitle("The gas at rest")
    return {"front_of_the_gas": figure, "gas": titled, "plain_gas": new_figure(4.0, 2.0)}


def _films(run):
    return {"flight": Animation(lambda time: new_figure(4.75, 1.0), run.times("gas"))}


@pytest.fixture(scope="module")
def gallery():
    """The case of the tests is in the gallery, with one metric that passes and one that does not; runs are fake."""
    import pellucid.case
    import pellucid.catalogue

    module = types.SimpleNamespace(metrics=lambda run: METRICS, figures=_figure, films=_films, CAPTIONS=CAPTIONS)
    case = free_flight(id="tests/free-flight", quick={"time.end": 0.5})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pellucid.catalogue, "module", lambda name: module if name == case.id else None)
        patch.setattr(pellucid.catalogue, "ids", lambda: (case.id,))
        patch.setattr(pellucid.case, "load", lambda name: case if name == case.id else load(name))
        patch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
        yield case


@pytest.fixture(scope="module")
def out(gallery, tmp_path_factory):
    return run_case(gallery, tmp_path_factory.mktemp("report") / "run").out


@pytest.fixture
def page(out):
    return (out / "report.html").read_text()


def test_needs_nothing_from_elsewhere(page):
    assert not re.search(r"<script[^>]*src=|<link", page)
    marks = re.sub(r"(<script.*?>).*?</script>", r"\1", page, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(?!data:)', marks)
    assert not re.search(r"@import|url\(", marks)


def test_has_a_view_before_the_figures(page):
    assert page.index('<section id="view">') < page.index('class="pellucid-view"') < page.index('<section id="figures">')


def test_shows_every_figure(page, out):
    pictures = [base64.b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', page)]
    names = ["front_of_the_gas", "gas", "plain_gas", "bodies_speed", "bodies_load", "energies", "momentum", "probes"]
    assert pictures == [(out / f"figures/{name}.png").read_bytes() for name in names]


def test_shows_the_films_first_with_letters_of_the_size_of_the_figures(page, out):
    (found,) = re.finditer(r'<img alt="How the gas flies." style="width: (\d+)%" src="data:image/gif;base64,([^"]+)"', page)
    assert base64.b64decode(found[2]) == (out / "figures/flight.gif").read_bytes()
    assert found[1] == "50", "half as wide as a figure of the report"
    assert found.start() < page.index("data:image/png")


def test_captions_are_those_of_the_gallery_or_else_the_titles(page):
    captions = re.findall("<figcaption>(.*?)</figcaption>", page)
    assert captions[1:4] == ["How far the gas &lt; came.", "The gas at rest", "Plain gas."]


def test_says_what_passed_and_what_failed(page):
    assert "1 of 2 checks failed" in page
    row = page[page.index("where the front is") :]
    assert row.index("2.500 m") < row.index("2.520 m") < row.index("pass")
    assert "not finite" in page


def test_text_of_the_case_stays_text(page):
    assert "Points fly &lt;freely&gt;." in page
    assert "loss&lt;0" in page


def test_shows_energies_facts_and_case(page):
    for text in (
        "kinetic energy",
        "relative error",
        "divided by the largest sum of m|v| or the sum of external impulses",
        "point-steps per second",
        "8 × 4 × 1 cells of 0.5 m, 1 m thick",
        "[[body]]",
    ):
        assert text in page


def test_a_run_of_which_there_is_nothing_yet_has_no_report(tmp_path, gallery):
    run = run_case(gallery, tmp_path / "run", until=0.1, report=False)
    run.folder.summary.unlink()
    rows = run.folder.history.read_text().splitlines(keepends=True)
    run.folder.history.write_text("".join(rows[:2]))
    with pytest.raises(UsageError, match=r"has no results yet\.\n    Run `pellucid resume .*` to continue it"):
        write_report(tmp_path / "run")
    run.folder.history.unlink()  # as where it was killed while bodies settled
    with pytest.raises(UsageError, match=r"has no results yet\.\n    Run `pellucid resume .*` to continue it"):
        write_report(tmp_path / "run")


def test_a_run_beside_is_drawn_and_checked_too(tmp_path, gallery):
    for name in ("one", "other"):
        run_case(gallery, tmp_path / name, report=False)
    probes = tmp_path / "one/figures/probes.png"
    page = write_report(tmp_path / "one", Run(tmp_path / "other")).read_text(encoding="utf-8")
    assert "Checks of the other run, other" in page
    both = probes.read_bytes()
    assert "Checks of the other run" not in write_report(tmp_path / "one").read_text(encoding="utf-8")
    assert probes.read_bytes() != both


def test_metrics_go_to_the_summary(out):
    summary = Run(out).summary
    assert summary["case"] == "tests/free-flight"
    front = {"value": 2.5, "reference": 2.52, "error": 0.008, "tolerance": 0.01, "pass": True}
    assert summary["metrics"]["front"] == front
    assert summary["metrics"]["loss<0"]["value"] is None


@pytest.mark.parametrize(("full", "end"), [(False, 0.5), (True, 1.0)])
def test_verify_runs_quick_or_full_variants(tmp_path, gallery, full, end):
    rows = verify(full=full, out=tmp_path)
    assert [(row.case, row.name, row.metric.passed) for row in rows] == [
        ("tests/free-flight", "front", True),
        ("tests/free-flight", "loss<0", False),
    ]
    assert Run(tmp_path / "tests/free-flight").summary["end_time"] == end


def test_verify_goes_on_after_a_run_that_stopped_itself(gallery, monkeypatch):
    monkeypatch.setattr(FakeSimulation, "breaks_at", 3)
    (row,) = verify()
    assert not row.metric.passed
    assert "point 7 of gas is lost" in row.metric.meaning


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.18001, "1.18"),
        (-0.02, "−0.02"),
        (12345.6, "12346"),
        (1.2341e-9, "1.234 × 10<sup>−9</sup>"),
        (8e-5, "8 × 10<sup>−5</sup>"),
        (float("nan"), "not finite"),
    ],
)
def test_numbers_for_the_eye(value, text):
    assert number(value) == text


def test_measured_numbers_keep_their_zeros():
    assert number(1.18, padded=True) == "1.180"
    assert number(5000.0, padded=True) == "5000"


def test_units_for_the_eye():
    assert pretty("kg/m^3") == "kg/m³"


def test_what_the_gallery_cannot_judge_is_told_and_fails_verification(tmp_path, gallery, monkeypatch):
    def cannot(run):
        raise ValueError("body `gas` is no ideal gas")

    import pellucid.catalogue

    monkeypatch.setattr(
        pellucid.catalogue, "module", lambda name: types.SimpleNamespace(metrics=cannot, figures=cannot, films=cannot)
    )
    with pytest.warns(UserWarning, match="could not be .* for this run: body `gas` is no ideal gas"):
        run = run_case(gallery, tmp_path / "run")
    assert run.summary["metrics"] == {}
    assert (run.out / "report.html").exists()
    with pytest.warns(UserWarning, match="metrics of tests/free-flight"):
        (row,) = verify()
    assert not row.metric.passed


def test_a_run_stopped_early_is_not_judged(tmp_path, gallery):
    run = run_case(gallery, tmp_path / "run", until=0.3)
    assert run.metrics == {}
    assert "Stopped early" in (run.out / "report.html").read_text()


def cut_off(data):
    return data[:700]


def of_another_program(data):
    return b"rubbish" * 100


def without_structure(data):
    return data[:2000] + bytes(2000) + data[4000:]


@pytest.mark.parametrize("damage", [cut_off, of_another_program, without_structure])
def test_a_run_with_damaged_fields_has_a_report_of_the_rest(tmp_path, damage):
    out = tmp_path / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FakeSimulation, "breaks_at", None)
        patch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
        run_case(free_flight(), out, until=0.3, report=False)
    path = out / "fields/gas.vtkhdf"
    path.write_bytes(damage(path.read_bytes()))
    before = path.read_bytes()
    result = CliRunner().invoke(app, ["report", str(out)])
    assert result.exit_code == 0, result.output
    assert f"not included in the report: {path} is damaged" in result.stderr
    page = (out / "report.html").read_text()
    assert f"Not included: {path} is damaged" in page
    assert 'alt="The energy balance' in page
    assert 'alt="The bodies' not in page
    assert path.read_bytes() == before
