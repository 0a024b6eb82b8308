"""Cases and simulations of closed membranes of triangles (balls, domes) that enclose a gas or a liquid."""

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
BALL = {"icosphere": {"centre": (0.3, 0.2, 0.1), "radius": 1.0, "refinements": 2}}
HELD = {"body": "skin", "where": {"box": {"lower": (-2, -2, -2), "upper": (2, 2, 2)}}, "fix": ["x", "y", "z"]}
AIR = {"pressure": 2000.0, "temperature": 300.0}


def skin(surface=BALL, **more):
    body = {"name": "skin", "kind": "membrane-elements", "elements": "triangles", "surface": surface}
    return body | {"thickness": 0.01, "material": SKIN} | more


def case(*enclosed, bodies=None, end=0.2, courant=0.9, **more):
    """Return a case with the given tables [[enclosed]]; each encloses a content in the body `skin`, unless it names another
    body."""
    held = [{"name": f"bag{number or ''}", "body": "skin"} | each for number, each in enumerate(enclosed)]
    time = {"end": end, "courant": courant} | more.pop("time", {})
    table = {"schema": 1, "title": "a test", "time": time, "body": bodies or [skin()], "enclosed": held}
    return Case.model_validate(table | more)


def simulation(*enclosed, threads=1, **more):
    return Simulation(case(*enclosed, **more), threads=threads)


def shown(sim, name="bag"):
    """Return the present values that the enclosed content `name` writes to the history, by column name without the name of
    the content."""
    return {key.removeprefix(f"{name}_"): value for key, value in sim.parts.columns().items() if key.startswith(name)}
