"""Flows through faces of the grid that cannot be: named when a case is read, or when its bodies are there."""

import pytest

from pellucid.case.reading import loads
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

TEXT = """\
schema = 1
title = "inflow"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.5
[time]
end = 0.1
[[body]]
name = "water"
shape = { box = { lower = [0, 0, 0], upper = [3, 2, 0] } }
material = { kind = "fluid", density = 1000, pressure = 0, eos = { kind = "tait", sound_speed = 20, exponent = 7 } }
[[body]]
name = "stone"
shape = { box = { lower = [3.5, 0, 0], upper = [4, 2, 0] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
[[support]]
where = "y-lower"
fix = "normal"
[[inflow]]
where = "x-lower"
body = "water"
velocity = 1
"""
PART = "{ box = { lower = [0, 0, 0], upper = [1, 2, 0] } }"
MOTION = f'[[motion]]\nname = "push"\nbody = "water"\nhold = ["x"]\npart = {PART}\n'
PUSH = f'[[load]]\nkind = "point-load"\nbody = "water"\nforce = [1, 0, 0]\nwhere = {PART}\n'
LAST = 'body = "water"\nvelocity = 1\n'
SUPPORT = '[[support]]\nwhere = "y-lower"\nfix = "normal"\n'
OUT = f'{LAST}[[outflow]]\nwhere = "x-upper"\n'
MISTAKES = {
    "a wall": (
        'where = "x-lower"',
        'where = "y-lower"',
        ["inflow.0.where", "constrains the whole face y-lower", 'remove "y-lower" from `support.0.where`'],
    ),
    "thin": ('where = "x-lower"', 'where = "z-lower"', ["inflow.0.where", "one cell thick along z"]),
    "a seam": ("cell = 0.5", 'cell = 0.5\nperiodic = ["x"]', ["inflow.0.where", "the grid is periodic along x"]),
    "no body": ('"water"\nvelocity', '"watr"\nvelocity', ["inflow.0.body", "did you mean `water`?"]),
    "a solid": ('"water"\nvelocity', '"stone"\nvelocity', ["inflow.0.body", "body stone is a solid", "name a fluid"]),
    "a body with a motion": (
        SUPPORT,
        SUPPORT + MOTION,
        ["inflow.0.body", "body water follows the motion `push`"],
    ),
    "cell_pressure": (
        'name = "water"',
        'name = "water"\ncell_pressure = true',
        ["inflow.0.body", "cell_pressure` of body water"],
    ),
    "both sizes": (
        "velocity = 1\n",
        "velocity = 1\nflow_rate = 2\n",
        ["inflow.0", "both `velocity` and `flow_rate`", "give one of them"],
    ),
    "no size": ("velocity = 1\n", "", ["inflow.0", "neither `velocity` nor `flow_rate` nor `pressure`"]),
    "backwards": ("velocity = 1\n", "velocity = -1\n", ["inflow.0.velocity", "at least 0"]),
    "turning round": (
        "velocity = 1\n",
        "velocity = 1\namplitude = { times = [0, 1], shares = [1, -0.5] }\n",
        ["inflow.0", "fraction -0.5", "cannot reverse"],
    ),
    "too fast": (
        "end = 0.1",
        "end = 0.1\nstep = 0.6",
        ["inflow.0.velocity", "cross 1.2 cells in a step", "use time.step = 0.4"],
    ),
    "two through one face": (
        LAST,
        f'{LAST}[[inflow]]\nwhere = "x-lower"\n{LAST}',
        ["inflow.1.where", "inflow number 1 also uses the face x-lower"],
    ),
    "in and out": (
        LAST,
        f'{LAST}[[outflow]]\nwhere = "x-lower"\n',
        ["outflow.0.where", "inflow number 1 enters through the face x-lower", "nothing can leave through it"],
    ),
    "an opening elsewhere": (
        LAST,
        f"{LAST}through = {{ box = {{ lower = [1, 0, 0], upper = [2, 1, 0] }} }}\n",
        ["inflow.0.through", "between 1 and 2 m along x", "but the face x-lower at 0 m"],
    ),
    "an opening beside the face": (
        LAST,
        f"{LAST}through = {{ box = {{ lower = [-1, 3, 0], upper = [2, 4, 0] }} }}\n",
        [
            "inflow.0.through",
            "between 3 and 4 m along y",
            "the face x-lower between 0 and 2 m",
            "extend or move it to the face",
        ],
    ),
    "an opening between points": (
        LAST,
        f"{LAST}through = {{ box = {{ lower = [-1, 0, 0], upper = [0.01, 1, 0] }} }}\n",
        ["inflow.0.through", "no seed point of body water lies in the opening", "one cell deep into the grid"],
    ),
    "a wall in the opening": (
        SUPPORT,
        f"{SUPPORT}[[support]]\nwhere = {{ box = {{ lower = [0, 0, 0], upper = [1, 2, 0] }} }}\n",
        ["inflow.0", "supports constrain all nodes of the opening in the face x-lower", "remove the supports"],
    ),
    "a load on some": (
        LAST,
        LAST + PUSH,
        ["load.0.where", "points enter body water later"],
    ),
    "an earlier run": (
        "[[body]]",
        '[start]\npath = "runs/x"\n[[body]]',
        ["inflow.0.body", "cannot continue from an earlier run"],
    ),
    "a steady state": ("[[body]]", "[steady]\n[[body]]", ["steady", "an [[inflow]] adds points"]),
    "a probe of a column's name": (
        SUPPORT,
        f'{SUPPORT}[[probe]]\nname = "inflow_mass"\nbody = "water"\nquantity = "mass"\n',
        ["probe.inflow_mass.name", "reserved for a column of the history"],
    ),
    "pressure and flow": (
        LAST,
        f"{OUT}pressure = 1\nvelocity = 1\n",
        ["outflow.0", "`pressure` and `velocity`"],
    ),
    "a flow out of two faces": (
        LAST,
        f'{LAST}[[outflow]]\nwhere = ["x-upper", "y-upper"]\nvelocity = 1\n',
        ["outflow.0", "applies to one face"],
    ),
    "a profile of nothing": (
        LAST,
        f'{OUT}profile = "parabolic"\n',
        ["outflow.0", "belongs to a prescribed flow"],
    ),
    "a rise of nothing": (
        LAST,
        f"{OUT}rise = 1\n",
        ["outflow.0", "there is nothing to change in time"],
    ),
    "two pressures": (
        LAST,
        f'{OUT}pressure = 1\n[[outflow]]\nwhere = "x-upper"\npressure = 2\n',
        ["outflow.1.where", "outflow number 1 already has a pressure"],
    ),
}


@pytest.mark.parametrize(("old", "new", "words"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_are_named(old, new, words):
    assert old in TEXT
    with pytest.raises(CaseError) as caught:
        loads(TEXT.replace(old, new, 1))
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "lower = [0, 0, 0], upper = [3, 2, 0]",
            "lower = [1, 0, 0], upper = [3, 2, 0]",
            [
                "inflow.0.where",
                "body water lies between 1 and 3 m along x, but the face x-lower at 0 m",
                "or define an opening with `through`",
            ],
        ),
        (
            LAST,
            f'{OUT}body = "water"\npressure = 1\n',
            ["outflow.0.pressure", "no point of water lies in the layer"],
        ),
        (
            LAST,
            f'{OUT}body = "water"\nvelocity = 1\n',
            ["outflow.0.where", "no body that can leave reaches"],
        ),
        (
            "velocity = 1\n",
            'velocity = 1\nprofile = "parabolic"\nthrough = { sphere = { centre = [0, 1, 0], radius = 0.8 } }\n',
            ["inflow.0.profile", "only slits, ducts and tubes", "define a box"],
        ),
        (SUPPORT, f'{SUPPORT}[[support]]\nwhere = "all-nodes"\n', ["inflow.0", "supports constrain all its nodes"]),
    ],
)
def test_what_only_the_bodies_tell_is_named(old, new, words):
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(CaseError) as caught:
        Simulation(loads(text), threads=1)
    for word in words:
        assert word in str(caught.value)
