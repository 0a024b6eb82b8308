"""A case: everything that a run needs, as data. The same classes are the case file and the Python interface."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, model_validator

from pellucid.bodies.models import Body
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.support import Support
from pellucid.contact.model import Contact
from pellucid.grid.model import GridCase
from pellucid.model import Model, Vector, parameter

ZERO = (0.0, 0.0, 0.0)
STEP_MARGIN = 0.05
"""By which a fixed step may exceed the stable one."""


class TimeCase(Model):
    """The clock: order of the step, length of the run, choice of the step, transfer of velocities."""

    scheme: Literal["musl", "usf", "usl"] = parameter("", "order of the step", "musl")
    end: float = parameter("s", "time at which the run ends", gt=0)
    step: float | None = parameter("s", "fixed time step; without it the Courant bound chooses", None, gt=0)
    courant: float = parameter("", "fraction of the largest stable step", 0.4, gt=0, le=1)
    transfer: Literal["flip", "pic", "blend", "apic"] = parameter("", "how velocities return to the points", "flip")
    flip_fraction: float = parameter("", 'share of FLIP in the transfer "blend", the rest is PIC', 0.99, ge=0, le=1)


class Probe(Model):
    """A column of `history.csv`: a field of a body reduced to one number, or a reaction, at each probe instant."""

    name: str = parameter("", "name of the column", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    body: str | None = parameter("", "name of the body", None)
    quantity: str = parameter("", 'name of a field of the body, such as pressure, or "reaction"')
    component: str | None = parameter("", "x, y, z or xx, yy, zz, yz, xz, xy; without it length or von Mises' stress", None)
    reduce: Literal["mean", "max", "min", "sum", "count", "nearest", "point"] = parameter(
        "",
        'how the points become one number: "count" those above a value; "nearest" takes the point that is nearest to a place '
        'at the moment, "point" follows the one that was nearest at the start',
        "mean",
    )
    at: Vector | None = parameter("m", 'place for "nearest" and "point"', None)
    above: float = parameter("", 'value that "count" compares with, in SI units', 0.0)
    change: bool = parameter("", "whether the value at the start is subtracted", False)
    carried: bool = parameter(
        "", 'for the position of a "point": where the place `at` itself is, which moves as the point nearest to it', False
    )
    condition: str | None = parameter(
        "", 'for quantity = "reaction": name of the support, motion or contact; its mean force since the row before', None
    )

    @model_validator(mode="after")
    def _is_complete(self) -> "Probe":
        if (self.reduce in ("nearest", "point")) != (self.at is not None):
            raise ValueError('`at = [x, y, z]` belongs to `reduce = "nearest"` or "point": give both or neither')
        if (self.quantity == "reaction") != (self.condition is not None):
            raise ValueError('`condition` belongs to `quantity = "reaction"`: give both or neither')
        if (self.body is None) != (self.condition is not None):
            raise ValueError("a probe needs the name of a `body`, or for a reaction that of a `condition`, and not both")
        if self.carried and (self.quantity, self.reduce) != ("position", "point"):
            raise ValueError('`carried` belongs to `quantity = "position"` with `reduce = "point"`')
        if self.carried and (self.component is None or self.change):
            raise ValueError(
                "`carried` needs a `component`, x, y or z; the change is the same with and without it: leave it out"
            )
        return self


class OutputCase(Model):
    """How often results are written."""

    history: float | None = parameter("s", "time between rows of history.csv; without it end/200", None, gt=0)
    frames: float | None = parameter("s", "time between frames of the fields; without it end/10", None, gt=0)
    checkpoint: float = parameter("s", "wall-clock time between checkpoints", 30.0, gt=0)


class EnergyCase(Model):
    """Limits on the relative error of the energy ledger."""

    warn: float = parameter("", "relative error that is warned of", 0.02, gt=0)
    stop: float = parameter("", "relative error that stops the run", 0.10, gt=0)


class TimesCase(Model):
    """What to expect on two cores, for `pellucid list`."""

    quick: float = parameter("s", "wall-clock time of the quick variant", ge=0)
    full: float = parameter("s", "wall-clock time of the full case", ge=0)


class Case(Model):
    """A complete case; build it in Python or read it with `pellucid.load`."""

    schema_version: Literal[1] = parameter("", "version of this format", 1, alias="schema")
    title: str = parameter("", "one line")
    id: str = parameter("", "gallery case whose metrics and figures apply", "")
    source: str = parameter("", "where the case comes from", "")
    description: str = parameter("", "what it shows", "")
    gravity: Vector = parameter("m/s^2", "acceleration of gravity", ZERO)
    grid: GridCase = parameter("", "the Eulerian grid")
    time: TimeCase = parameter("", "the clock")
    body: tuple[Body, ...] = parameter("", "the bodies", min_length=1)
    support: tuple[Support, ...] = parameter("", "held nodes", ())
    motion: tuple[Motion, ...] = parameter("", "prescribed motions", ())
    absorbing: tuple[Absorbing, ...] = parameter("", "faces that let waves out", ())
    pressure: tuple[Pressure, ...] = parameter("", "pressures on membranes", ())
    contact: tuple[Contact, ...] = parameter("", "how bodies of different velocity fields touch", ())
    probe: tuple[Probe, ...] = parameter("", "columns of the history", ())
    output: OutputCase = parameter("", "how often results are written", OutputCase())
    energy: EnergyCase = parameter("", "limits of the energy ledger", EnergyCase())
    times: TimesCase | None = parameter("", "expected wall-clock times", None)
    quick: dict[str, Any] = Field({}, description="settings of the quick variant, by dotted key")

    @model_validator(mode="after")
    def _parts_fit_together(self) -> "Case":
        from pellucid.case.relations import Conditions, Disagreement, findings

        conditions = Conditions(
            list(self.support), list(self.motion), list(self.absorbing), list(self.pressure), list(self.contact)
        )
        found = findings(self.grid, list(self.body), conditions, list(self.probe), self.time, self.output)
        if found:
            raise Disagreement(found)
        return self

    def history_interval(self) -> float:
        """Time between rows of the history [s]."""
        return self.output.history or self.time.end / 200

    def frame_interval(self) -> float:
        """Time between frames of the fields [s]."""
        return self.output.frames or self.time.end / 10

    def with_settings(self, settings: Mapping[str, Any]) -> "Case":
        """The case with values put at dotted keys, such as {"grid.cell": 0.02, "body.driver.velocity": [1, 0, 0]}.

        Raises CaseError naming the setting where the key or the value is impossible.
        """
        from pellucid.case.reading import changed

        return changed(self, settings)

    def quick_variant(self) -> "Case":
        """The case with its own quick settings, for a look within seconds; the case itself where it has none."""
        return self.with_settings(self.quick) if self.quick else self

    def to_data(self) -> dict[str, Any]:
        """The case as plain tables, lists, texts and numbers in SI units, defaults included, None left out."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)
