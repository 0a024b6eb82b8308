"""A small case with every part that a case may have."""

import pytest

TEXT = """\
schema = 1
title = "A drop and a block"
gravity = [0, -9.81, 0]

[grid]
lower = [0, 0, 0]
upper = [1.0, 0.5, 0.0]
cell = 0.05
functions = "gimp"

[time]
end = 0.1
courant = 0.5

[[body]]
name = "drop"
kind = "material-points"
shape = { cylinder = { centre = [0.25, 0.25, 0], radius = 0.1 } }
points_per_cell = [2, 2, 1]
velocity = [1.0, 0, 0]
material = { kind = "fluid", density = 1000.0, eos = { kind = "tait", sound_speed = 20.0 } }

[[body]]
name = "block"
shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }
points_per_cell = 4

[body.material]
kind = "linear-elastic"
density = 1200.0
young_modulus = 1e5
poisson_ratio = 0.3

[[support]]
where = "x-lower"
fix = "normal"

[[support]]
where = { box = { lower = [0.9, 0, 0], upper = [1, 0.5, 0] } }
fix = ["x", "y"]

[[probe]]
name = "front"
body = "drop"
quantity = "position"
component = "x"
reduce = "max"

[quick]
"grid.cell" = 0.1
"""


@pytest.fixture
def text() -> str:
    return TEXT
