"""Curves that figures of basic cases show beside the run: writes `src/pellucid/gallery/basics/*.csv`."""

from pathlib import Path

import numpy as np

from pellucid.conditions.signals.displacements import Ramp
from pellucid.references.solids import Layer, at_contact

GALLERY = Path(__file__).parents[2] / "src/pellucid/gallery/basics"
SLOPE, ALONG, ACROSS = np.radians(30.0), 9.81 * 0.5, 9.81 * np.sqrt(0.75)  # [m/s²]


def write(name: str, **columns: "np.ndarray | list[float]") -> None:
    """A table of a case; names of columns end in their unit, behind two underlines."""
    names = ",".join("{} [{}]".format(*column.replace("_per_", "/").split("__")) for column in columns)
    header = f"# validation/basics-exact-curves/curves.py\n{names}"
    np.savetxt(GALLERY / f"{name}.csv", np.column_stack(list(columns.values())), "%.8g", ",", header=header, comments="")


def rolling() -> None:
    """What rolls on a slope of 30 degrees turns as well: a cylinder has 2/3 of the acceleration, a ball 5/7."""
    time = np.linspace(0.0, 1.0, 101)
    way = 0.5 * ALONG * time**2
    write("rolling-discs", time__s=time, rolls__m=2.0 / 3.0 * way, glides__m=way)
    write("rolling-ball", time__s=time, way__m=5.0 / 7.0 * way, speed__m_per_s=5.0 / 7.0 * ALONG * time)


def rolling_as_weight_grows() -> None:
    """Speeds of balls on a slope of 30 degrees while gravity grows over 0.2 s: solid ones have 5/7, hollow ones 3/5."""
    time, grown = np.linspace(0.0, 0.5, 101), 0.2
    speed = ALONG * np.where(time < grown, 0.5 * time**2 / grown, time - 0.5 * grown)
    rolls = {"solid_rolls__m_per_s": 5.0 / 7.0 * speed, "hollow_rolls__m_per_s": 3.0 / 5.0 * speed}
    write("rolling-balls", time__s=time, **rolls, glides__m_per_s=speed)


def sliding() -> None:
    """Coulomb's friction of 0.3 on a slope of 30 degrees, and how far a block with ν = 0.3 swings about its compression."""
    end, height, density, young = 1.0, 0.25, 2000.0, 1e7
    pressed = density * height**2 * 9.81 * 0.52 / 0.7 / (3.0 * young)
    slides = [0.0, (ALONG - 0.3 * ACROSS) * end]
    lowest = {"lowest__m": [-2.0 * pressed] * 2, "lowest_of_softer__m": [-8.0 * pressed] * 2}
    write("blocks-on-slope", time__s=[0.0, end], slides__m_per_s=slides, **lowest)


def impacts() -> None:
    """A bar that meets another, or a wall, feels ρ c v A until the front is back (Timoshenko & Goodier, section 167).

    Discs leave at 0.905 of their speed, by finite elements (validation/basics-colliding-discs).
    """
    touch, left, end = 0.01, 0.03, 0.05  # bars of 1 m² and 1 m, c = 100 m/s, ρ c A = 1e5 N s/m, 0.1 m/s, 1 mm apart
    time = [0.0, touch, touch, left, left, end]
    write(
        "colliding-bars",
        time__s=time,
        striker__m_per_s=[0.1, 0.1, 0.1, 0.0, 0.0, 0.0],
        struck__m_per_s=[0.0, 0.0, 0.0, 0.1, 0.1, 0.1],
        force__N=[0.0, 0.0, 5e3, 5e3, 0.0, 0.0],
    )
    write("colliding-discs", time__s=[0.0, 3.6], lower__m_per_s=[-0.0905] * 2, upper__m_per_s=[0.0905] * 2)
    length, area, wave, density, speed, fall = 0.2, 0.05**2, 10.0, 1000.0, 0.1, 0.001
    touch, left, end = fall / speed, fall / speed + 2.0 * length / wave, 0.06
    force = density * wave * speed * area
    write(
        "elastic-block-drop",
        time__s=[0.0, touch, touch, left, left, end],
        velocity__m_per_s=[-speed, -speed, -speed, speed, speed, speed],
        force__N=[0.0, 0.0, force, force, 0.0, 0.0],
    )


def pressed() -> None:
    """A quarter of the force on a rigid ball that is pressed into a layer, as `pellucid.references.solids` has it."""
    layer, radius, centre = Layer(1e4, 0.3, 0.02, bonded=True), 0.01, 0.0302
    time = np.linspace(0.0, 0.054, 109)
    moved = Ramp(distance=-0.0012, duration=0.03).function()
    depth = np.array([max(0.0, 0.02 + radius - centre - moved(float(at))) for at in time])
    widest = np.sqrt(2.0 * radius * depth.max())
    pairs = [at_contact(layer, radius, float(contact)) for contact in np.linspace(1e-3, 1.0, 60) * widest]
    levels, forces = np.array([(0.0, 0.0), *pairs]).T
    write("ball-on-tissue", time__s=time, force__N=0.25 * np.interp(depth, levels, forces))


def gliding() -> None:
    """The way of a bead that glides over a disc until its weight no longer holds it there, from the start of the case."""
    hill, radius, gravity, step = np.array([3.6, 0.6]), 0.8, 9.81, 1e-5
    start, velocity = np.array([3.2619053906, 1.3250462296]) - hill, np.array([1.4500924593, 0.6761892188])
    angle, rate, places = float(np.arctan2(start[0], start[1])), float(np.linalg.norm(velocity)) / radius, []
    while gravity * np.cos(angle) > radius * rate**2:
        places.append(radius * np.array([np.sin(angle), np.cos(angle)]))
        rate += step * gravity / radius * np.sin(angle + 0.5 * step * rate)
        angle += step * rate
    along = radius * rate * np.array([np.cos(angle), -np.sin(angle)])
    flown = np.linspace(0.0, 0.4, 41)[:, None]
    falls = places[-1] + flown * along - 0.5 * gravity * flown**2 * [0.0, 1.0]
    x, y = (hill + np.concatenate([places[::1000], falls])).T
    write("gliding-discs", x__m=x, y__m=y)


if __name__ == "__main__":
    rolling()
    rolling_as_weight_grows()
    sliding()
    impacts()
    pressed()
    gliding()
