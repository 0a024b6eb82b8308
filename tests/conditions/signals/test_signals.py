"""Prescribed displacements as functions of time, and tables that make no sense."""

from math import pi

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.conditions.pressure import Pressure
from pellucid.conditions.signals.displacements import Ramp, Sine, Steady, Table
from pellucid.smooth_step import smooth_step


def table(tmp_path, text):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    return {"kind": "table", "path": str(path)}


def signals(tmp_path):
    rows = "time,displacement\n0,1e-3\n1,2e-3\n3,2.5e-3\n4,2e-3\n"
    return [
        Sine(amplitude=2e-3, period=0.5, phase=0.3),
        Ramp(distance=-3e-3, duration=2.0, start=0.5),
        Steady(velocity=-0.25),
        Table.model_validate(table(tmp_path, rows)),
    ]


@pytest.mark.parametrize("number", range(4))
def test_every_displacement_starts_at_zero_and_keeps_below_its_top_speed(tmp_path, number):
    signal = signals(tmp_path)[number]
    u = signal.function()
    assert u(0.0) == 0.0
    t = np.linspace(0.0, 4.0, 4001)
    speed = np.abs(np.diff([u(time) for time in t])).max() / (t[1] - t[0])
    assert 0.0 < speed <= signal.top_speed() * (1.0 + 1e-9)


def test_a_sine_is_that_of_its_formula():
    u = Sine(amplitude=13.5e-6, period=1e-4).function()
    for time in (1e-6, 2.5e-5, 6e-5):
        assert u(time) == pytest.approx(13.5e-6 * np.sin(2 * pi * time / 1e-4), rel=1e-14)


def test_a_ramp_is_smooth_and_arrives():
    u = Ramp(distance=2.0, duration=4.0, start=1.0).function()
    assert (u(0.5), u(3.0), u(5.0), u(9.0)) == (0.0, pytest.approx(1.0), pytest.approx(2.0), 2.0)
    assert u(1.0 + 1e-3) < 1e-8, "velocity and acceleration begin at zero"


def test_a_table_goes_through_its_rows_without_overshoot(tmp_path):
    u = signals(tmp_path)[3].function()
    assert [u(t) for t in (0.0, 1.0, 3.0, 4.0)] == pytest.approx([0.0, 1e-3, 1.5e-3, 1e-3], rel=1e-12)
    assert max(u(t) for t in np.linspace(0.0, 4.0, 401)) == pytest.approx(1.5e-3, rel=1e-12)
    assert u(10.0) == u(4.0), "constant behind its end"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,0\n2,1e-3\n1,2e-3\n", "line 3 of .*: time 1 s does not come after 2 s; sort the rows by time"),
        ("0,0\n1,1e-3\n1,2e-3\n", "line 3 of .*: time 1 s does not come after 1 s"),
        ("time,u\n0,0\n1,a\n", "line 3 of .* does not have two numbers like the first row; every row needs time"),
        ("0,0\n1\n", "line 2 of .* does not have two numbers"),
        ("0,0\n1,nan\n", "line 2 of .* does not have two numbers"),
        ("time,u\n0,0\n", "has 1 rows of numbers; it needs at least two"),
    ],
)
def test_tables_that_make_no_sense(tmp_path, text, words):
    with pytest.raises(ValidationError, match=words):
        Table.model_validate(table(tmp_path, text))


def test_a_table_that_is_not_there(tmp_path):
    with pytest.raises(ValidationError, match=r"none\.csv"):
        Table.model_validate({"kind": "table", "path": str(tmp_path / "none.csv")})


def test_a_pressure_rises_smoothly_or_at_once():
    assert Pressure(body="lid", value=800.0).at(0.0) == 800.0
    slow = Pressure(body="lid", value=800.0, rise=2.0)
    assert (slow.at(0.0), slow.at(1.0), slow.at(2.0), slow.at(3.0)) == (0.0, pytest.approx(400.0), 800.0, 800.0)
    assert smooth_step(-1.0) == 0.0
