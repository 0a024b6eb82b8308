"""What a report tells of a fluid that flows through the grid."""

from pellucid.case import load
from pellucid.results.report.report import write_report
from pellucid.running.launch import run_case

DUCT = """
schema = 1
title = "a plug"
[grid]
lower = [0, 0, 0]
upper = [0.2, 0.1, 0]
cell = 0.02
thickness = 0.02
[time]
end = 0.02
[[body]]
name = "water"
shape = { box = { lower = [0, 0, 0], upper = [0.2, 0.1, 0] } }
velocity = [2, 0, 0]
[body.material]
kind = "fluid"
density = 1000
viscosity = 1
implicit_viscosity = true
eos = { kind = "tait", sound_speed = 20 }
[[support]]
where = "y-lower"
fix = "normal"
[[support]]
where = "y-upper"
fix = "normal"
[[inflow]]
where = "x-lower"
body = "water"
velocity = 2
[[outflow]]
where = "x-upper"
pressure = 0
"""


def test_what_passed_the_faces_of_the_grid_is_told(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(DUCT)
    run = run_case(load(case), tmp_path / "run", threads=1)
    page = write_report(run).read_text()
    assert run.summary["inflow"]["points"] == 40
    assert "0.08 kg in 40 points entered, 0.08 kg in 40 points left" in page
    assert "2 × support, 1 × inflow, 1 × outflow" in page
    assert "iterations per step on average" in page
