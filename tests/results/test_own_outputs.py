"""Pictures, films, plots and checks that a case asks for."""

import json

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import pellucid
from pellucid.case.judgement import Check
from pellucid.case.measured import MeasuredCurve
from pellucid.case.picture import Picture
from pellucid.case.plot import Plot
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.results.metrics import Readings, metric_of
from pellucid.results.pictures.own import picture, plot
from pellucid.results.pictures.painter import Painter
from pellucid.results.pictures.style import house_style

BLOCK = """
schema = 1
title = "A block falls"
gravity = [0, -10, 0]
grid = { lower = [0, 0, 0], upper = [1, 2, 0.1], cell = 0.1 }
time = { end = 0.2, step = 1e-3 }
output = { history = 0.01, frames = 0.05 }

[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [0.3, 1, 0], upper = [0.7, 1.4, 0.1] } }
points_per_cell = [2, 2, 1]
material = { kind = "linear-elastic", density = 1000, young_modulus = 1e4, poisson_ratio = 0.3 }

[[probe]]
name = "height"
body = "block"
quantity = "position"
component = "y"
"""
OUTPUTS = """
[[picture]]
name = "fall"
title = "The block before and after."
quantity = "velocity"
component = "y"
unit = "cm/s"
times = [0]
smallest = "height"

[[film]]
name = "moving"
pictures = 3

[[plot]]
name = "path"
y = "height"
y_unit = "cm"
x_unit = "ms"
measured = [{ path = "fall.csv", y = "height", deviation = "sd", label = "by hand" }]

[[check]]
name = "fallen"
column = "height"
reference = "100 cm"
tolerance = "1 cm"
source = "g t^2/2"

[[check]]
name = "path"
column = "height"
curve = { path = "fall.csv", y = "height" }
relative_tolerance = 1e-2
source = "g t^2/2"
"""


def curve(folder, head="time [ms],height [cm],sd [mm]", factor=1.0):
    rows = [f"{1e3 * t},{factor * (120.0 - 500.0 * t * t)},5" for t in (0.2, 0.05, 0.1, 0.15)]
    (folder / "fall.csv").write_text("\n".join([head, *rows]) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A case with all of these, and its run in `run`."""
    folder = tmp_path_factory.mktemp("own")
    curve(folder)
    (folder / "case.toml").write_text(BLOCK + OUTPUTS)
    result = CliRunner().invoke(app, ["run", str(folder / "case.toml"), "--out", str(folder / "run")])
    assert result.exit_code == 0, result.output
    return folder


def test_the_report_has_them_with_their_captions(folder):
    report = (folder / "run/report.html").read_text()
    assert "The block before and after." in report
    for name in ("fall.png", "path.png", "moving.gif"):
        assert (folder / "run/figures" / name).is_file()
    with Image.open(folder / "run/figures/moving.gif") as film:
        assert film.n_frames == 3


def test_checks_are_metrics_with_their_sources(folder):
    run = pellucid.Run(folder / "run")
    fallen, path = run.metrics["fallen"], run.metrics["path"]
    assert fallen.value == pytest.approx(run.history["height"][-1])
    assert (fallen.reference, fallen.tolerance, fallen.unit) == (1.0, 0.01, "m")
    assert "g t^2/2" in fallen.meaning
    at = np.interp([0.05, 0.1, 0.15, 0.2], run.history["time"], run.history["height"])
    exact = 1.2 - 5.0 * np.array([0.05, 0.1, 0.15, 0.2]) ** 2
    assert path.error == pytest.approx(np.sqrt(np.mean((at - exact) ** 2)), abs=1e-12)
    assert path.tolerance == pytest.approx(1e-2 * exact[0])
    assert fallen.passed
    assert path.passed
    assert set(json.loads((folder / "run/summary.json").read_text())["metrics"]) == {"fallen", "path"}


def test_a_picture_shows_the_frames_nearest_to_times_and_extremes(folder):
    run = pellucid.Run(folder / "run")
    with house_style():
        figure = picture(run, run.stored.picture[0])
    *panels, bar = figure.axes
    assert [axes.get_title() for axes in panels] == ["t = 0 s", "t = 200 ms"]
    assert bar.get_ylabel() == "velocity y [cm/s]"
    assert bar.get_ylim()[0] == pytest.approx(-200.0, rel=0.02)


def test_a_plot_has_its_units_and_the_measured_points(folder):
    run = pellucid.Run(folder / "run")
    with house_style():
        (axes,) = plot(run, run.stored.plot[0]).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [ms]", "height [cm]")
    assert axes.lines[0].get_ydata()[0] == pytest.approx(120.0)
    points = axes.containers[0].lines[0]
    assert points.get_xdata() == pytest.approx([50, 100, 150, 200])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["height", "by hand"]


def test_panels_stand_side_by_side_over_what_they_differ_by(folder):
    run = pellucid.Run(folder / "run")
    curve = {"path": str(folder / "fall.csv"), "y": "height", "line": True}
    asked = Plot(
        name="all",
        y="height",
        y_unit="cm",
        difference=True,
        measured=[curve],
        x_label="force [p$N",
        beside=[{"x": "height", "y": ["kinetic_energy", "strain_energy"], "y_limits": [0.0, 2.0], "y_label": "energies"}],
    )
    with house_style():
        height, energies, difference = plot(run, asked).axes
    theory = height.containers[0].lines[0]
    assert theory.get_linestyle() == "-"
    assert theory.get_xdata() == pytest.approx([0.05, 0.1, 0.15, 0.2])
    rows = run.history["time"] >= 0.05
    exact = np.interp(run.history["time"], theory.get_xdata(), theory.get_ydata())
    assert difference.lines[0].get_ydata()[rows] == pytest.approx((100.0 * run.history["height"] - exact)[rows])
    assert np.isnan(difference.lines[0].get_ydata()[~rows]).all(), "of where the curve is not nothing is known"
    assert energies.get_ylim() == (0.0, 2.0)
    assert (energies.get_xlabel(), energies.get_ylabel()) == ("height [m]", "energies")
    assert (height.get_xlabel(), difference.get_xlabel()) == ("", r"force [p\$N")
    height.figure.canvas.draw()
    assert all(text.get_text() for text in energies.get_xticklabels()), "panels beside have numbers of their own"
    assert difference.get_ylabel() == "difference [cm]"


def test_a_line_of_theory_goes_as_far_as_the_run(folder, tmp_path):
    (tmp_path / "falls.csv").write_text("time [s],height [m]\n-1,0\n0.1,0\n0.1,1\n5,1\n")
    run = pellucid.Run(folder / "run")
    with house_style():
        (axes,) = plot(run, Plot(name="a", y="height", measured=[{"path": str(tmp_path / "falls.csv"), "line": True}])).axes
    line = axes.containers[0].lines[0]
    assert line.get_xdata() == pytest.approx([0.0, 0.1, 0.1, run.history["time"][-1]])
    assert line.get_ydata().tolist() == [0.0, 0.0, 1.0, 1.0]


def test_a_window_shows_a_part_of_a_flat_picture(folder):
    run = pellucid.Run(folder / "run")
    window = {"lower": [0.25, 0.5], "upper": [0.75, 1.5]}
    with house_style():
        axes = picture(run, Picture(name="part", window=window)).axes[0]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.25, 0.75), (0.5, 1.5))


@pytest.mark.slow
def test_verify_and_converge_take_them(folder):
    case = str(folder / "case.toml")
    result = CliRunner().invoke(app, ["verify", case])
    assert result.exit_code == 0, result.output
    assert "all 2 metrics pass" in result.output
    result = CliRunner().invoke(app, ["converge", case, "--over", "time.step=2e-3,1e-3", "--metric", "fallen"])
    assert result.exit_code == 0, result.output


def test_a_check_that_falls_short_fails_verification(folder):
    (folder / "wrong.toml").write_text((folder / "case.toml").read_text().replace("100 cm", "101.5 cm"))
    result = CliRunner().invoke(app, ["verify", str(folder / "wrong.toml")])
    assert result.exit_code == 3
    assert "fallen" in result.output


def test_they_may_change_when_a_run_goes_on(folder):
    """Measured curves too: the run does not see them."""
    text = (folder / "case.toml").read_text()
    (folder / "more.toml").write_text(text)
    out = folder / "more"
    assert CliRunner().invoke(app, ["run", str(folder / "more.toml"), "--out", str(out), "--until", "0.1"]).exit_code == 0
    curve(folder, factor=1.001)
    result = CliRunner().invoke(app, ["resume", str(out), "--set", "plot.path.x_unit=s"])
    curve(folder)
    assert result.exit_code == 0, result.output


def test_a_run_that_is_done_takes_others_from_a_file(folder):
    out = folder / "others"
    (folder / "others.toml").write_text((folder / "case.toml").read_text())
    assert CliRunner().invoke(app, ["run", str(folder / "others.toml"), "--out", str(out), "--until", "0.1"]).exit_code == 0
    before = (out / "history.csv").read_bytes()
    (folder / "new.toml").write_text((folder / "case.toml").read_text() + '\n[[plot]]\nname = "another"\ny = "height"\n')
    result = CliRunner().invoke(app, ["report", str(out), "--from", str(folder / "new.toml")])
    assert result.exit_code == 0, result.output
    assert (out / "figures" / "another.png").is_file()
    assert (out / "history.csv").read_bytes() == before
    (folder / "bad.toml").write_text((folder / "new.toml").read_text().replace('y = "height"\n', 'y = "depth"\n'))
    kept = (out / "case.toml").read_bytes()
    assert CliRunner().invoke(app, ["report", str(out), "--from", str(folder / "bad.toml")]).exit_code == 2
    assert (out / "case.toml").read_bytes() == kept


@pytest.mark.parametrize(
    ("old", "new", "place", "text"),
    [
        ('y = "height"\ny_unit', 'y = "heigth"\ny_unit', "plot.path.y", "did you mean `height`?"),
        ('y = "height"\ny_unit', 'y = ["height", "kinetic_energy"]\ny_unit', "plot.path.y", "must have the same unit"),
        ('y_unit = "cm"', 'y_unit = "kg"', "plot.path.y_unit", "dimension"),
        ('path = "fall.csv", y = "height", dev', 'path = "no.csv", y = "height", dev', "plot.path.measured.0", "cannot read"),
        (
            'deviation = "sd"',
            'deviation = "sigma"',
            "plot.path.measured.0",
            "no column is named sigma; available: time, height, sd",
        ),
        ('name = "path"\ny', 'name = "probes"\ny', "plot.probes.name", "reserved for a figure of the report"),
        ('name = "moving"', 'name = "fall"', "film.fall.name", "another figure has this name"),
        ('quantity = "velocity"', 'quantity = "heat"', "picture.fall.quantity", "no drawn body has this field"),
        ('component = "y"\nunit', 'component = "xy"\nunit', "picture.fall.component", "has the components x, y, z"),
        ('unit = "cm/s"', 'unit = "kPa"', "picture.fall.unit", "dimension"),
        ('y_unit = "cm"', "y_limits = [2, 1]", "plot.path", "must be less than the second"),
        ("measured = [{", "difference = true\n# [{", "plot.path", "requires a `measured` curve"),
        ('y_unit = "cm"', "beside = [{ y = 'heigth' }]", "plot.path.beside.0.y", "did you mean `height`?"),
        ("times = [0]", "window = { lower = [1, 0], upper = [0, 1] }", "picture.fall.window", "must be less than `upper`"),
        ("times = [0]", "instants = 3", "picture.fall", "cannot be combined with `times`"),
        ("times = [0]", "slice = { across = 'x', at = 0 }", "picture.fall.slice", "a plane case cannot be sliced"),
        (
            'reference = "100 cm"',
            'when = { column = "heigth", reaches = 1 }\nreference = "100 cm"',
            "check.fallen.when.column",
            "height",
        ),
        (
            'reference = "100 cm"',
            'when = { column = "height", reaches = "1 s" }\nreference = "100 cm"',
            "when.reaches",
            "dimension",
        ),
        (
            'reference = "100 cm"',
            'at = 0.1\nwhen = { column = "height", reaches = 1 }\nreference = "100 cm"',
            "check.fallen",
            "one of the two",
        ),
        ('reference = "100 cm"', 'at = 1\nreference = "100 cm"', "check.fallen.at", "Set a time up to time.end."),
        ('smallest = "height"', 'smallest = "width"', "picture.fall.smallest", "not a column of the history"),
        ('reference = "100 cm"', 'reference = "100 Pa"', "check.fallen.reference", "dimension"),
        ('tolerance = "1 cm"', 'tolerance = "-1 cm"', "check.fallen.tolerance", "must be greater than 0"),
        ('reference = "100 cm"', "", "check.fallen", "requires either a `reference` or a `curve`"),
    ],
)
def test_what_cannot_be_is_told_before_the_run(folder, old, new, place, text):
    whole = BLOCK + OUTPUTS
    assert old in whole
    (folder / "bad.toml").write_text(whole.replace(old, new, 1))
    with pytest.raises(CaseError) as caught:
        pellucid.load(folder / "bad.toml")
    told = str(caught.value)
    assert place in told
    assert text in told


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("", "is empty"),
        ("time [ms],height [cm]\n", "contains no row of numbers"),
        ("time,height\n1,2\n", "fall.csv:1: the column time has no unit"),
        ("time [ms],height [cm]\n1,2\n2,x\n", 'fall.csv:3: height = "x" is not a finite number'),
        ("time [ms],height [cm]\n1\n", "fall.csv:2: the row has 1 cells, but there are 2 columns"),
        ("time [ms],height [Pa]\n1,2\n", "the unit of the column height"),
    ],
)
def test_a_file_without_such_a_curve_is_told(tmp_path, content, text):
    (tmp_path / "fall.csv").write_text(content)
    (tmp_path / "case.toml").write_text(BLOCK + OUTPUTS.replace(', deviation = "sd"', ""))
    with pytest.raises(CaseError, match=r"fall\.csv") as caught:
        pellucid.load(tmp_path / "case.toml")
    assert text in str(caught.value)


def test_units_may_stand_in_a_row_of_their_own(tmp_path):
    (tmp_path / "fall.csv").write_text("time,height\n#ms,cm\n50,118.75\n")
    (tmp_path / "case.toml").write_text(BLOCK + OUTPUTS.replace(', deviation = "sd"', ""))
    x, y, none = pellucid.load(tmp_path / "case.toml").plot[0].measured[0].read("s", "m")
    assert (x.tolist(), y.tolist(), none) == ([0.05], [1.1875], None)


@pytest.mark.parametrize("remark", ["# by hand\n", "# by hand, twice\n# s, m\n"])
@pytest.mark.parametrize("head", ["time [ms],height [cm]", "time,height\n# ms,cm"])
def test_remarks_may_precede_the_names(tmp_path, remark, head):
    (tmp_path / "fall.csv").write_text(f"{remark}{head}\n50,118.75\n")
    assert [list(column) for column in MeasuredCurve(path=str(tmp_path / "fall.csv")).read("s", "m")[:2]] == [[0.05], [1.1875]]


def test_names_may_stand_behind_the_sign_of_remarks(tmp_path):
    """As numpy.savetxt writes them."""
    (tmp_path / "fall.csv").write_text("# time,height\n# ms,cm\n50,118.75\n")
    assert [list(column) for column in MeasuredCurve(path=str(tmp_path / "fall.csv")).read("s", "m")[:2]] == [[0.05], [1.1875]]


def test_curves_that_are_gone_and_slices_of_nothing_do_not_end_a_report(folder, tmp_path):
    """The run is done: what cannot be drawn is told, what cannot be judged fails."""
    curve(tmp_path)
    (tmp_path / "case.toml").write_text(BLOCK + OUTPUTS.replace('name = "moving"', 'name = "moving"\nbodies = "block"'))
    run = pellucid.run(pellucid.load(tmp_path / "case.toml"), out=tmp_path / "run", report=False)
    (tmp_path / "fall.csv").unlink()
    again = pellucid.Run(run.out)
    assert not again.metrics["path"].passed
    assert "cannot read" in again.metrics["path"].meaning
    assert again.metrics["fallen"].passed
    painter = Painter(again)
    assert painter.draw_or_notice("path") is None
    assert any("fall.csv" in text for text in painter.notices)
    assert painter.draw_or_notice("fall") is not None


@pytest.mark.parametrize(
    ("take", "found"), [("largest", 1.0), ("smallest", -3.0), ("mean", -0.5), ("last", 0.5), ("largest-size", 3.0)]
)
def test_a_column_becomes_one_number(take, found):
    asked = Check(name="a", column="x", take=take, reference=0.0, tolerance=1.0, source="by hand")
    columns = {"time": np.arange(4.0), "x": np.array([1.0, -3.0, -0.5, 0.5])}
    metric = metric_of(asked, Readings(columns), {"time": "s", "x": "1"})
    assert metric.value == found
    assert metric.passed == (abs(found) <= 1.0)


@pytest.mark.parametrize(("reaches", "found"), [("5 cm", 1.5), (0.3, 9.0), (0.0, 0.0), ("9 m", np.nan)])
def test_a_check_reads_a_column_when_another_passes(reaches, found):
    history = {"time": np.array([0.0, 1.0, 2.0, 3.0]), "way": np.array([0.0, 0.1, 0.0, 0.3])}
    history["count"] = 3.0 * history["time"]
    asked = Check(
        name="a", column="count", when={"column": "way", "reaches": reaches}, reference=1.5, tolerance=1e-9, source="by hand"
    )
    metric = metric_of(asked, Readings(history), {"way": "m", "count": "1"})
    assert metric.value == pytest.approx(found, nan_ok=True)
    assert metric.passed is (found == 1.5)


@pytest.mark.parametrize(("take", "found"), [("time-of-largest", 2.0), ("time-of-smallest", 1.0)])
def test_a_check_takes_the_time_of_an_extreme(take, found):
    history = {"time": np.array([0.0, 1.0, 2.0, 3.0]), "way": np.array([0.0, -0.1, 0.3, 0.3])}
    asked = Check(name="a", column="way", take=take, reference="2 s", tolerance="1e-9 s", source="by hand")
    metric = metric_of(asked, Readings(history), {"way": "m"})
    assert (metric.value, metric.unit, metric.passed) == (found, "s", found == 2.0)
    nothing = metric_of(asked, Readings(history | {"way": np.full(4, np.nan)}), {"way": "m"})
    assert np.isnan(nothing.value)
    assert not nothing.passed
