"""Probes of the shape of bodies: area, enclosed volume, ellipsoid, extent."""

import numpy as np
import pytest

from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation.simulation import Simulation

CELL = """
schema = 1
title = "A tilted ellipsoid"
[time]
end = 0.1
[[body]]
name = "cell"
kind = "membrane-elements"
thickness = 0.01
material = { kind = "neo-hookean-membrane", density = 100, young_modulus = 100, poisson_ratio = 0.3 }
[body.surface]
ellipsoid = { centre = [2, 2, 2], radii = [1.5, 1, 0.5], refinements = 3 }
rotate = { axis = [0, 1, 0], angle = -30 }
"""


def probed(text, *probes):
    tables = "".join(f'[[probe]]\nname = "p{n}"\nbody = "{body}"\n{rest}\n' for n, (body, rest) in enumerate(probes))
    sim = Simulation(loads(text + tables), threads=1)
    reader = ProbeReader(sim.case.probe)
    reader.start(sim.bodies)
    return reader.read(sim.bodies, {}, 0.0)


def test_a_cell_tells_its_shape():
    volume, area, deformation, angle, long, short, change, reach = probed(
        CELL,
        ("cell", 'quantity = "enclosed_volume"'),
        ("cell", 'quantity = "surface_area"'),
        ("cell", 'quantity = "taylor_deformation"'),
        ("cell", 'quantity = "inclination"'),
        ("cell", 'quantity = "semi_axes"\ncomponent = "long"'),
        ("cell", 'quantity = "semi_axes"\ncomponent = "short"'),
        ("cell", 'quantity = "enclosed_volume"\nchange = true'),
        ("cell", 'quantity = "extent"\ncomponent = "y"'),
    )
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 0.75, rel=0.01)
    assert area == pytest.approx(12.0, rel=0.1)
    assert deformation == pytest.approx(0.5, rel=1e-3)
    assert np.degrees(angle) == pytest.approx(30.0, abs=0.1)
    assert (long, short) == pytest.approx((1.5, 0.5), rel=5e-3)
    assert change == 0.0
    assert reach == pytest.approx(2.0, rel=5e-3)


def test_a_ball_has_no_inclination():
    ball = CELL.replace(
        "ellipsoid = { centre = [2, 2, 2], radii = [1.5, 1, 0.5]", "icosphere = { centre = [2, 2, 2], radius = 1"
    )
    assert ball != CELL
    assert np.isnan(probed(ball, ("cell", 'quantity = "inclination"'))[0])


def test_what_has_no_surface_is_refused():
    block = '[[body]]\nname = "block"\nshape = { box = { lower = [0, 0, 0], upper = [1, 1, 1] } }\nfield = "own"\n'
    block += 'material = { kind = "neo-hookean", density = 1, young_modulus = 1, poisson_ratio = 0.3 }\n'
    grid = "[grid]\nlower = [0, 0, 0]\nupper = [4, 4, 4]\ncell = 0.5\n"
    with pytest.raises(CaseError, match="enclosed_volume requires a surface of triangles, which body block does not have"):
        probed(CELL + grid + block, ("block", 'quantity = "enclosed_volume"'))
    assert probed(CELL + grid + block, ("block", 'quantity = "extent"\ncomponent = "x"'))[0] == pytest.approx(0.75)
