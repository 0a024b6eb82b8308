"""Data model of enclosed gas or liquid, given by mass."""

from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from typing import ClassVar, Self

from pydantic import PrivateAttr

from pellucid.conditions.enclosed.contents import Contents, Gas, Liquid
from pellucid.conditions.enclosed.foretold import Inflator, Vent, encloses_problems, membrane_at_start
from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.model import Model, check, name_parameter, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, LoadKind, Swing
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart

CHANNELS = {
    "enclosed_energy": -1.0,
    "outside_work": -1.0,
    "inflator_energy": 1.0,
    "vent_energy": -1.0,
    "enclosed_heat": 1.0,
}
"""Channels of the energy balance with their signs: increase of the energy of enclosed gases and liquids since the start,
their work against the outside pressure and on lids, energy of the inflow, energy of the outflow, and heat absorbed by
isothermal gases."""


class Amount(Model):
    """Amount of a gas or a liquid."""

    mass: float | None = parameter("kg", "initial mass", None, ge=0)
    pressure: float | None = parameter("Pa", "alternative to `mass`: initial absolute pressure", None, ge=0)

    @check
    def _is_one_amount(self) -> None:
        if (self.mass is None) == (self.pressure is None):
            raise ValueError("give either `mass` or `pressure`: each follows from the other and the initial volume")


class GasCase(Amount):
    """An ideal gas with constant heat capacities. Default: air."""

    temperature: float = parameter("K", "initial temperature", gt=0)
    gamma: float = parameter("", "ratio γ of the heat capacities", 1.4, gt=1)
    gas_constant: float = parameter("J/(kg*K)", "specific gas constant R in p V = m R T", 287.05, gt=0)
    isothermal: bool = parameter(
        "", "true: the gas keeps its temperature by heat exchange; false: no heat crosses the membrane", False
    )

    def contents(self, volume: float) -> Contents:
        """Build the gas that fills an initial volume [m³]."""
        mass = self.mass
        if mass is None:
            mass = (self.pressure or 0.0) * volume / (self.gas_constant * self.temperature)
        return Gas(mass, self.temperature, self.gamma, self.gas_constant, self.isothermal)


class LiquidCase(Amount):
    """A liquid with constant bulk modulus."""

    bulk_modulus: float = parameter("Pa", "bulk modulus K in p = K (m/(ρ₀V) - 1)", gt=0)
    density: float = parameter("kg/m^3", "density ρ₀ at zero pressure", gt=0)

    @check
    def _is_there(self) -> None:
        if self.mass == 0.0:
            raise ValueError(
                "mass = 0: the pressure of a liquid without mass is undefined; give a mass above 0, or remove this table"
            )

    def contents(self, volume: float) -> Contents:
        """Build the liquid that fills an initial volume [m³]."""
        mass = self.mass
        if mass is None:
            mass = self.density * volume * (1.0 + (self.pressure or 0.0) / self.bulk_modulus)
        return Liquid(mass, self.bulk_modulus, self.density, volume)


class Enclosed(Condition):
    """Gas or liquid in a membrane, given by its mass; its pressure follows from the volume."""

    unique_name: ClassVar[bool] = True
    load_kind: ClassVar[LoadKind] = "volume"
    swings_as: ClassVar[Swing] = Swing("spring", "its membrane oscillates on the enclosed gas or liquid")

    name: str = name_parameter("name of its history columns: NAME_pressure, NAME_volume, NAME_mass ...")
    body: str = parameter("", "name of the enclosing membrane")
    gas: GasCase | None = parameter("", "gas in the membrane", None)
    liquid: LiquidCase | None = parameter("", "alternative to `gas`: a liquid", None)
    outside: float = parameter("Pa", "absolute pressure outside the membrane", 0.0, ge=0)
    lids: bool = parameter(
        "",
        "true: flat lids close the rims of an open membrane; the pressure on the lids is not applied to any body",
        False,
    )
    inside: tuple[str, ...] = parameter(
        "", "closed membranes inside: their volumes are excluded, and the pressure acts on them from outside", ()
    )
    inflator: Inflator | None = parameter("", "inflow over time", None)
    vent: tuple[Vent, ...] = parameter("", "openings for outflow", ())
    leak: float = parameter(
        "kg/(m^2*s*Pa)",
        "leakage coefficient: mass flux per unit area and pressure difference",
        0.0,
        ge=0,
    )

    _may_tear: bool = PrivateAttr(default=False)
    """True if damage can tear holes in the membrane; set by `in_case`."""
    _is_implicit: bool = PrivateAttr(default=False)
    """True if liquids in the velocity field of the membranes have an implicit pressure; set by `in_case`."""

    @property
    def is_implicit(self) -> bool:
        """True if the pressure of the contents is solved for together with the implicit pressure of the liquids in the velocity
        field of the membranes."""
        return self._is_implicit

    def in_case(self, bodies: Sequence[BodyModel], conditions: Sequence[Condition], thin: tuple[bool, bool, bool]) -> Self:
        """Return a copy that records whether the membrane can tear (its material has a damage law), and whether liquids around
        the membranes have an implicit pressure; bodies: all bodies of the case; the other arguments are not used."""
        membrane = next((body for body in bodies if body.name == self.body), None)
        copy = self.model_copy()
        copy._may_tear = getattr(getattr(membrane, "material", None), "damage", None) is not None
        fields = {body.field for body in bodies if body.name in (self.body, *self.inside)}
        stresses = ((body.field, body.implicit_stress) for body in bodies)
        implicit = {field for field, stress in stresses if stress is not None and stress.stiffness > 0.0}
        copy._is_implicit = len(fields) == 1 and fields <= implicit
        return copy

    @check
    def _has_contents(self) -> None:
        if self.gas is None and self.liquid is None:
            what = [key for key in ("inflator", "vent", "leak") if getattr(self, key)]
            text = (
                f"the membrane has {what[0]} but neither gas nor liquid" if what else "the membrane has neither gas nor liquid"
            )
            raise Refusal(text, "give `gas`, such as { pressure = 1e5, temperature = 293 }, or `liquid`")
        if self.gas is not None and self.liquid is not None:
            raise Refusal("the membrane has both a gas and a liquid", "remove one: a volume contains either a gas or a liquid")
        if self.inflator is not None and self.inflator.has_temperatures != (self.gas is not None):
            if self.gas is not None:
                raise Refusal("the inflator of a gas has no temperatures", "add `temperatures`, or a third column in the file")
            raise Refusal("the inflator of a liquid has temperatures", "remove them: a liquid has no temperature")

    def amount(self) -> GasCase | LiquidCase:
        """Return the model of the gas or of the liquid."""
        found = self.gas or self.liquid
        if found is None:
            raise ValueError("it has neither gas nor liquid")
        return found

    @property
    def lets_out(self) -> bool:
        """True if contents can flow out through vents or through the membrane."""
        return bool(self.vent) or self.leak > 0.0

    def load_channel(self) -> str:
        """Return the name of the channel (entry of the energy balance) for the work of the gauge pressure on membranes. This
        work is exchanged between contents and membrane, so that it does not change the total energy."""
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
        if start is None or self.is_implicit:
            return 0.0
        stiffness = self.amount().contents(start.volume).stiffness(start.volume)
        return 0.5 * sqrt(max(stiffness, 0.0) * start.mobility)

    def why_not_steady(self) -> Reason | None:
        remedy = (
            f"use a case that can have a factored stiffness, or remove [steady] and set `body.{self.body}.damping`, or use "
            "[settle] instead of [steady]"
        )
        return Reason("the relaxation cannot find the equilibrium of a membrane with a gas or liquid", remedy)

    def why_not_factored(self) -> Reason | None:
        in_time = "remove [steady], or use [settle] instead of it"
        if self.inside:
            text = f"the factored stiffness does not include membranes inside `{self.name}`"
            return Reason(text, f"remove `inside`; or {in_time}")
        if self.lets_out or self._may_tear:
            text = f"there is no equilibrium while `{self.name}` flows out"
            return Reason(text, f"remove its vents and leaks, and damage of the membrane; or {in_time}")
        if self.inflator is not None and self.gas is not None and not self.gas.isothermal:
            text = f"the temperature of the gas `{self.name}` depends on how fast the inflator fills it"
            return Reason(text, f"set isothermal = true for the gas; or {in_time}")
        return None

    @classmethod
    def activate(cls, conditions: Sequence["Enclosed"], assembly: Assembly) -> Sequence[StepPart]:
        from pellucid.conditions.enclosed.active import ActiveEnclosed
        from pellucid.conditions.enclosed.steady import SteadyEnclosed

        if assembly.finds_equilibria:
            return [SteadyEnclosed(enclosed, assembly) for enclosed in conditions]
        return [ActiveEnclosed(enclosed, assembly) for enclosed in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about membranes that do not exist, enclose no volume, are named twice or already have contents,
        and about reserved names. path: location of the condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from encloses_problems(self.body, self.lids, path, parts, allows_flat=False)
        for number, name in enumerate(self.inside):
            here = (*path, "inside", number)
            if name == self.body or name in self.inside[:number]:
                yield Finding(here, f"body {name} is named twice", "remove one of the two names")
            else:
                yield from encloses_problems(name, False, path, parts, allows_flat=False, at=here)
        for (_, other_number), other in parts.placed(Enclosed):
            if other is not self and other.body == self.body and int(other_number) < int(path[-1]):
                text = f"body {self.body} already contains `{other.name}`"
                yield Finding(
                    (*path, "body"), text, "a membrane can enclose only one gas or liquid: remove one of the two [[enclosed]]"
                )
        if self.name in ("inflow", "outflow"):
            text = f"the history already has a column {self.name}_mass"
            yield Finding((*path, "name"), text, "choose another name")
