"""Quantities shown in pictures of bodies: fields, speed, displacement, or the load of each kind of body."""

from collections.abc import Iterable, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np

from pellucid.bodies.models import BODIES
from pellucid.results.pictures.camera import Plane, View
from pellucid.results.pictures.style import COLOURS, DIVERGING, SEQUENTIAL, Extend, Figure, colour_bar, with_unit
from pellucid.results.pictures.surroundings import Mirror, places_unmoved
from pellucid.results.storage.probes import scalar
from pellucid.results.storage.run_folder import StoredBody
from pellucid.state import FIELDS
from pellucid.units import to_si

VIEW = View(-50.0, 22.0)
NORMAL_VELOCITY, BY_BODY = "normal_velocity", "bodies"
"""Names of quantities: normal velocity of surfaces in space, and one colour for each body."""

Fields = dict[str, np.ndarray]
"""Fields of a body at one time, by name."""


class Slice(NamedTuple):
    """Selection of the points that were next to a plane normal to an axis (0, 1 or 2) in the initial configuration."""

    axis: int
    at: float  # position of the plane along the axis [m]
    reach: float  # largest distance of a selected point from the plane [m]


class Look(NamedTuple):
    """Settings of a picture of bodies, for the stages that draw it.

    Colours: `quantity`, `component`, `unit` of the colour bar (empty: SI unit), and `limits` of the colour bar in this
    unit. `names`: bodies to draw (default: all). `view`: direction of view. `cut`: the material in front of this plane is
    not drawn; by default, a plane is chosen if a body surrounds another. `halved`: True to put the cut plane through the
    middle of the largest solid. `mirrors`: planes of symmetry, whose mirror images are drawn too. `arrows`: True to draw
    the tangential velocity on surfaces. `slice`: draw only the points of a slice, as a flat picture. `window`: lower and
    upper corner of the rectangle that a flat picture shows [m].
    """

    quantity: str
    component: str | None = None
    unit: str = ""
    limits: tuple[float, float] | None = None
    names: tuple[str, ...] = ()
    view: View = VIEW
    cut: Plane | None = None
    halved: bool = False
    mirrors: tuple[Mirror, ...] = ()
    arrows: bool = False
    slice: Slice | None = None
    window: tuple[np.ndarray, np.ndarray] | None = None


BOTH_SIGNS = 0.2
"""Smallest ratio of the largest magnitudes of both signs, the smaller divided by the larger, for which limits are symmetric
about zero."""


class Limits(NamedTuple):
    """Limits of a colour bar: the values at its ends (`low`, `high`), and the ends beyond which values of the picture lie
    (`extend`: "neither", "min", "max" or "both", as in matplotlib)."""

    low: float
    high: float
    extend: Extend

    @property
    def palette(self) -> str:
        """Name of the colour map: diverging if the limits are symmetric about zero, otherwise sequential."""
        return DIVERGING if self.low == -self.high else SEQUENTIAL


def is_still(body: StoredBody) -> bool:
    """Return True if the points of a body of this kind never move, as in pure diffusion."""
    return body.kind in BODIES.entries and not BODIES.entries[body.kind].moves


def _pictured(body: StoredBody) -> tuple[str, str] | None:
    """Return the field that shows the load of a body (its mechanical state), as its kind declares it: name of the field and
    label of the colour bar. None if the kind declares none."""
    return BODIES.entries[body.kind].pictured if body.kind in BODIES.entries else None


def is_film(body: StoredBody) -> bool:
    """True for a fluid film, which has no thickness and only surface stresses."""
    return body.kind == "fluid-film"


def word_of(bodies: Sequence[StoredBody], look: Look) -> str:
    """Return the label of the colour bar for several bodies: the quantity that `look` selects, its component and unit."""
    name, unit = _meaning(bodies, look.quantity)
    if look.quantity == "stress" and not look.component:
        name = "von Mises stress"
    part = f" {look.component}" if look.component else ""
    return with_unit(name + part, look.unit or unit)


def _meaning(bodies: Sequence[StoredBody], quantity: str) -> tuple[str, str]:
    """Return the label and the SI unit of a quantity that colours can show. The quantity is the name of a field, "speed",
    "displacement", "normal_velocity", or "load" (the field that the kinds of the bodies declare, otherwise pressure or von
    Mises stress)."""
    if quantity in ("speed", "displacement", NORMAL_VELOCITY):
        return quantity, FIELDS["position" if quantity == "displacement" else "velocity"].unit
    if quantity != "load":
        return quantity, FIELDS[quantity].unit
    own = {_pictured(body) for body in bodies}
    if len(own) == 1 and (found := own.pop()) is not None:
        return found[1], FIELDS[found[0]].unit
    kinds = dict.fromkeys("pressure" if body.equation_of_state else "von Mises stress" for body in bodies)
    return " or ".join(kinds), FIELDS["stress"].unit


def colours_of(names: Iterable[str]) -> dict[str, str]:
    """Return a colour (matplotlib name or code) for each of the bodies with the given names, by name."""
    return dict(zip(names, cycle(COLOURS), strict=False))


def explain(figure: Figure, bodies: Sequence[StoredBody], look: Look, limited: Limits, shrink: float = 0.7) -> None:
    """Draw, next to all axes, the colour bar of the quantity, or a legend if `look` gives each body its own colour.

    limited: limits of the colour bar. shrink: length of the colour bar relative to the axes.
    """
    from matplotlib.lines import Line2D

    if look.quantity != BY_BODY:
        colour_bar(figure, word_of(bodies, look), limited, limited.palette, shrink)
        return
    colours = colours_of(body.name for body in bodies)
    dots = [Line2D([], [], color=colour, marker="o", linestyle="", label=name) for name, colour in colours.items()]
    figure.legend(handles=dots, loc="outside lower center", ncols=min(6, len(dots)))


def there(fields: Fields) -> np.ndarray:
    """Return a mask of the points that are inside the grid and have finite positions, shape (n,). The positions of all
    other points are NaN in the results."""
    found = np.isfinite(fields["position"]).all(axis=1)
    return np.asarray(found & (fields["mass"] > 0.0) if "mass" in fields else found)


def values_of(body: StoredBody, fields: Fields, look: Look, start: np.ndarray) -> np.ndarray:
    """Return the values that colour the points of a body, shape (n,), in the unit of `look`; NaN for points that have left the
    grid and for bodies without this field.

    The quantity "load" is the field that the kind of body declares, otherwise the pressure of a body with an equation of state,
    otherwise von Mises' equivalent stress. start: initial positions [m], shape (n, 3), the reference of displacements.
    """
    name = look.quantity
    if name == BY_BODY:
        return np.zeros(len(start))
    if name == "load":
        own = _pictured(body)
        name = own[0] if own is not None else "pressure" if body.equation_of_state else "stress"
    if name == "displacement":
        values = scalar(places_unmoved(fields) - start)
    elif name == "speed":
        values = scalar(fields["velocity"])
    elif name in fields:
        values = scalar(fields[name], look.component, FIELDS[name].names if name in FIELDS else ())
    else:
        return np.full(len(start), np.nan)
    if "mass" in fields:
        values = np.where(fields["mass"] > 0.0, values, np.nan)
    return values / to_si(f"1 {look.unit}", _meaning([body], look.quantity)[1]) if look.unit else values


def limits_of(values: list[np.ndarray], look: Look) -> Limits:
    """Return the limits of the colour bar for values of several bodies or times: the limits set in `look`, otherwise the result
    of `limits`."""
    if look.quantity == BY_BODY:
        return Limits(0.0, 1.0, "neither")
    if look.limits is None:
        return limits(values)
    low, high = look.limits
    least, most = (find(array) for find, array in ((np.nanmin, np.concatenate(values)), (np.nanmax, np.concatenate(values))))
    return Limits(low, high, _beyond(least < low, most > high))


def limits(values: list[np.ndarray]) -> Limits:
    """Return common limits of the colour bar for several arrays, robust against a few extreme values.

    The lower limit is negative only if values are. If large values of both signs occur, the limits are symmetric about
    zero.
    """
    everything = np.concatenate(values)
    everything = everything[np.isfinite(everything)]
    if not everything.size:
        return Limits(0.0, 1.0, "neither")
    least, most = float(everything.min()), float(everything.max())
    low, high = (float(value) for value in np.percentile(everything, (0.5, 99.5)))
    if high <= low:  # nearly all values are the same
        if least >= 0.0:
            low, high = 0.0, high or 1.0
        elif low != 0.0:
            low, high = low - 0.5 * abs(low), low + 0.5 * abs(low)
        else:
            low, high = least, most
    if min(-low, high) > BOTH_SIGNS * max(-low, high):
        low, high = -max(-low, high), max(-low, high)
    return Limits(low, high, _beyond(least < low, most > high))


def _beyond(below: bool, above: bool) -> Extend:
    return "both" if below and above else "min" if below else "max" if above else "neither"
