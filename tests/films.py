"""Case files with one fluid film, and their simulation."""

from pellucid.case import loads
from pellucid.simulation.simulation import Simulation

CASE = """
schema = 1
title = "A film"

[time]
end = {end}

[[body]]
name = "film"
kind = "{kind}"
shape = {{ {shape} }}
material = {{ kind = "lipid-film", density = 1, viscosity = 1, dilatational_viscosity = 1, stiffness = {stiffness}{bending} }}
{more}

[output]
history = {every}
"""


def case(
    shape="ellipse = { radius = 1, nodes = 20 }",
    end=1.0,
    stiffness=1.0,
    bending="",
    more="",
    loads_of="",
    every=0.05,
    kind="fluid-film",
):
    text = CASE.format(shape=shape, end=end, stiffness=stiffness, bending=bending, more=more, every=every, kind=kind)
    return loads(text + loads_of, "film.toml")


def ran(of):
    simulation = Simulation(of)
    while not simulation.clock.finished(None):
        simulation.step()
    return simulation, simulation.bodies[0]


PRESSURE = """
[[load]]
kind = "film-pressure"
body = "film"
value = {value}
on = "{on}"
"""
