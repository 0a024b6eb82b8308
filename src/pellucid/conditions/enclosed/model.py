"""Enclosed gas or liquid by mass, as the user describes it."""

from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from typing import ClassVar, Self

from pydantic import PrivateAttr

from pellucid.conditions.enclosed.contents import Contents, Gas, Liquid
from pellucid.conditions.enclosed.flows import Inflator, Vent
from pellucid.conditions.enclosed.foretold import membrane_at_start
from pellucid.conditions.enclosed.problems import encloses_problems
from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.model import Model, check, name_parameter, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, Swing
from pellucid.parts.part import Parts

CHANNELS = {
    "enclosed_energy": -1.0,
    "outside_work": -1.0,
    "inflator_energy": 1.0,
    "vent_energy": -1.0,
    "enclosed_heat": 1.0,
}
"""Of the balance, with their signs: what gases and liquids hold more than at the start, their work on what is around and on
lids, what flows in and out, what keeps their temperature."""


class Amount(Model):
    """Amount of a gas or a liquid."""

    mass: float | None = parameter("kg", "how much there is at the start", None, ge=0)
    pressure: float | None = parameter("Pa", "instead of the mass, the absolute pressure at the start", None, ge=0)

    @check
    def _is_one_amount(self) -> None:
        if (self.mass is None) == (self.pressure is None):
            raise ValueError("give either `mass` or `pressure`: one follows from the other by the volume at the start")


class GasCase(Amount):
    """An ideal gas of constant heat capacities; those of air are the defaults."""

    temperature: float = parameter("K", "at the start", gt=0)
    gamma: float = parameter("", "ratio of its heat capacities", 1.4, gt=1)
    gas_constant: float = parameter("J/(kg*K)", "R of p V = m R T", 287.05, gt=0)
    isothermal: bool = parameter("", "whether heat keeps it at its temperature; without it no heat passes the membrane", False)

    def contents(self, volume: float) -> Contents:
        """Build the contents for an initial volume [m³]."""
        mass = self.mass
        if mass is None:
            mass = (self.pressure or 0.0) * volume / (self.gas_constant * self.temperature)
        return Gas(mass, self.temperature, self.gamma, self.gas_constant, self.isothermal)


class LiquidCase(Amount):
    """A liquid of constant bulk modulus."""

    bulk_modulus: float = parameter("Pa", "K of p = K (m/(ρ₀V) - 1)", gt=0)
    density: float = parameter("kg/m^3", "ρ₀, without pressure", gt=0)

    @check
    def _is_there(self) -> None:
        if self.mass == 0.0:
            raise ValueError("mass = 0: a volume without liquid has no pressure of one; give more, or leave it out")

    def contents(self, volume: float) -> Contents:
        """Build the contents for an initial volume [m³]."""
        mass = self.mass
        if mass is None:
            mass = self.density * volume * (1.0 + (self.pressure or 0.0) / self.bulk_modulus)
        return Liquid(mass, self.bulk_modulus, self.density, volume)


class Enclosed(Condition):
    """Gas or liquid in a membrane, by its mass: its pressure follows from the volume."""

    unique_name: ClassVar[bool] = True
    swings_as: ClassVar[Swing] = Swing("spring", "its membrane oscillates on the enclosed gas or liquid")

    name: str = name_parameter("name of its columns in the history: NAME_pressure, NAME_volume, NAME_mass ...")
    body: str = parameter("", "name of the membrane that encloses it")
    gas: GasCase | None = parameter("", "the gas", None)
    liquid: LiquidCase | None = parameter("", "instead of a gas, the liquid", None)
    outside: float = parameter("Pa", "absolute pressure outside of the membrane", 0.0, ge=0)
    lids: bool = parameter(
        "",
        "whether lids close the rims of an open membrane, over which nothing is pushed that is computed",
        False,
    )
    inside: tuple[str, ...] = parameter(
        "", "closed membranes inside, whose volumes do not belong to it and which its pressure pushes from outside", ()
    )
    inflator: Inflator | None = parameter("", "what flows in over time", None)
    vent: tuple[Vent, ...] = parameter("", "openings through which it flows out", ())
    leak: float = parameter(
        "kg/(m^2*s*Pa)",
        "mass that passes unit of area of the membrane on unit of time and of the difference of pressures",
        0.0,
        ge=0,
    )

    _may_tear: bool = PrivateAttr(default=False)
    """True if damage can make holes in its membrane, in a case (`in_case`)."""

    def in_case(self, bodies: Sequence[BodyModel], conditions: Sequence[Condition], thin: tuple[bool, bool, bool]) -> Self:
        """Return a copy that records whether the membrane can tear."""
        membrane = next((body for body in bodies if body.name == self.body), None)
        copy = self.model_copy()
        copy._may_tear = getattr(getattr(membrane, "material", None), "damage", None) is not None
        return copy

    @check
    def _has_contents(self) -> None:
        if self.gas is None and self.liquid is None:
            what = [key for key in ("inflator", "vent", "leak") if getattr(self, key)]
            text = f"has {what[0]} and neither gas nor liquid" if what else "has neither gas nor liquid"
            raise Refusal(text, "give `gas`, such as { pressure = 1e5, temperature = 293 }, or `liquid`")
        if self.gas is not None and self.liquid is not None:
            raise Refusal("has both a gas and a liquid", "leave one out: one volume holds one of them")
        if self.inflator is not None and self.inflator.has_temperatures != (self.gas is not None):
            if self.gas is not None:
                raise Refusal("the inflator of a gas says nothing of temperatures", "give `temperatures`, or a third column")
            raise Refusal("the inflator of a liquid has temperatures", "leave them out: a liquid has none")

    def amount(self) -> GasCase | LiquidCase:
        """Return the gas or the liquid."""
        found = self.gas or self.liquid
        if found is None:
            raise ValueError("it has neither gas nor liquid")
        return found

    @property
    def lets_out(self) -> bool:
        """True if anything can flow out."""
        return bool(self.vent) or self.leak > 0.0

    def load_channel(self) -> str:
        """Return the channel of the work of the pressure on membranes, minus that of the outside pressure: an exchange
        within the balance."""
        return "enclosed_work"

    def channels(self) -> Sequence[Channel]:
        left_out = {
            "inflator_energy": self.inflator is None,
            "vent_energy": not (self.lets_out or self._may_tear),
            "enclosed_heat": self.gas is None or not self.gas.isothermal,
        }
        return [Channel(name, sign) for name, sign in CHANNELS.items() if not left_out.get(name, False)]

    def columns(self) -> Mapping[str, str]:
        units = {"pressure": "Pa", "gauge_pressure": "Pa", "volume": "m^3", "mass": "kg"}
        units |= {"temperature": "K"} if self.gas is not None else {}
        units |= {"vent_flow": "kg/s"} if self.vent else {}
        units |= {"leak_flow": "kg/s"} if self.leak > 0.0 else {}
        units |= {"hole_flow": "kg/s", "hole_area": "m^2"} if self._may_tear else {}
        return {f"{self.name}_{what}": unit for what, unit in units.items()}

    def swing_of(self, body: BodyModel, rate: float, cell: float | None) -> float:
        start = membrane_at_start(body) if body.name == self.body else None
        if start is None:
            return 0.0
        stiffness = self.amount().contents(start.volume).stiffness(start.volume)
        return 0.5 * sqrt(max(stiffness, 0.0) * start.mobility)

    def why_not_steady(self) -> Reason | None:
        remedy = (
            f"remove [steady] and set `body.{self.body}.damping`, or use [settle] instead of [steady]; a closed membrane of "
            "triangles can have a `volume_stiffness` instead of the [[enclosed]] liquid"
        )
        return Reason("[steady] brings no membrane with a gas or liquid to rest", remedy)

    @classmethod
    def activate(cls, conditions: Sequence["Enclosed"], assembly: Assembly) -> Sequence[ActiveCondition]:
        from pellucid.conditions.enclosed.active import ActiveEnclosed

        return [ActiveEnclosed(enclosed, assembly) for enclosed in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report membranes that do not exist, enclose nothing or have contents already."""
        yield from super().problems(path, parts)
        yield from encloses_problems(self.body, self.lids, path, parts, allows_flat=False)
        for number, name in enumerate(self.inside):
            here = (*path, "inside", number)
            if name == self.body or name in self.inside[:number]:
                yield Finding(here, f"body {name} is named twice", "leave it out here")
            else:
                yield from encloses_problems(name, False, path, parts, allows_flat=False, at=here)
        for (_, other_number), other in parts.placed(Enclosed):
            if other is not self and other.body == self.body and int(other_number) < int(path[-1]):
                text = f"body {self.body} holds `{other.name}` already"
                yield Finding((*path, "body"), text, "one membrane encloses one gas or liquid: leave one of the two out")
        if self.name in ("inflow", "outflow"):
            text = f"the history has a column {self.name}_mass of its own"
            yield Finding((*path, "name"), text, "choose another name")
