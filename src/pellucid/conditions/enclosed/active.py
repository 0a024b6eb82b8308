"""Active condition of an enclosed gas or liquid: its pressure on the membranes, its energy and its mass flows in each step."""

from collections.abc import Mapping, Sequence
from copy import copy
from math import sqrt
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.conditions.enclosed.contents import Contents
from pellucid.conditions.enclosed.volume import EnclosedVolume, Enclosure
from pellucid.energy import FIRST_LOAD, INTERNAL, StepWork
from pellucid.energy.budget import ROUNDING_SHARE
from pellucid.errors import RunStopped
from pellucid.grid.clearing import Clearing
from pellucid.grid.nodal_fields import STEP, SUM, NodalField, allocate, with_memory
from pellucid.grid.transfer import scatter_vectors
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.annotations import Assembly
from pellucid.step.part import AddedStiffness, StepPart

if TYPE_CHECKING:
    from pellucid.conditions.enclosed.model import Enclosed


class PressedNodes(NamedTuple):
    """Nodes that move a membrane with contents whose pressure is implicit."""

    volume_slope: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "m²", "derivative of the enclosed volume with respect to the position of the node")
    ]


class ActiveEnclosed(StepPart):
    """A gas or liquid in a membrane, in a run.

    The pressure acts on the membrane with the geometry at the start of a step: its nodal forces are p ∂V/∂x, with the
    pressure p, the enclosed volume V and the nodal positions x. Where liquids of the velocity field have an implicit
    pressure, p is that at the end of the step (`PressedContents`). The energy of the contents is updated with the volume at
    the end of the step. The total energy is therefore conserved to the order of the time integration. Mass that flows in or
    out is exchanged half at the volume of the start of the step and half at the volume of its end.
    """

    def __init__(self, enclosed: "Enclosed", assembly: Assembly) -> None:
        self._model, self._layout = enclosed, assembly.layout
        self._space = EnclosedVolume(enclosed.body, enclosed.inside, assembly, enclosed.load_channel())
        self._now = self._space.now()
        self._check(self._now)
        self.contents: Contents = enclosed.amount().contents(self._now.volume)
        self._open = [vent.opens_at == 0.0 for vent in enclosed.vent]
        self._vent_flow = self._leak_flow = self._hole_flow = 0.0
        self._passing, self._time = 0.0, 0.0
        self._works: dict[str, float] = {}
        if enclosed.is_implicit:
            self._load = assembly.load_column(enclosed.body, enclosed.load_channel()) - FIRST_LOAD
            self._field.contents.append(self)
            self._nodes = with_memory(allocate(PressedNodes, 0), self._field.grid.n_nodes, "volume_slope")
            self._clear = Clearing(STEP, self._field.grid.rows, self._nodes)

    def try_out(self) -> None:
        """Add half of the initial power of the gauge pressure [W] to the sum `half_power` of the first body."""
        self._count_power(self._space.growth(self._now))

    def at_stake(self) -> float:
        """Return a bound of the rounding errors of the energy of the contents and of the work against the outside pressure
        [J]. Only this bound, not the energy of the contents itself, is part of the reference of the energy error."""
        return ROUNDING_SHARE * (abs(self.contents.energy) + abs(self._model.outside) * self._now.volume)

    def _check(self, now: Enclosure) -> None:
        """Raise RunStopped if the enclosed volume in the state `now` is not positive, or if a membrane inside has failed
        points."""
        if not now.volume > 0.0:
            what = (
                f"the membrane {self._model.body} of `{self._model.name}` encloses "
                f"{now.volume:.3g} m3, but the volume must be positive"
            )
            text = "it is turned inside out, or bodies inside fill it: check the loads and contacts of the membrane"
            raise RunStopped(f"{what}: {text}", body=self._model.body)
        for name, failed in zip(self._model.inside, now.failed[1:], strict=True):
            if failed:
                what = f"membrane {name} inside `{self._model.name}` has failed at {failed} points"
                text = "its contents would mix with the surroundings, which is not computed"
                advice = f"remove `damage` of body {name}, or set `time.end` before this time"
                raise RunStopped(f"{what}: {text}; {advice}", body=name)

    @property
    def _gauge(self) -> float:
        """Gauge pressure of the contents: their pressure minus the outside pressure [Pa]."""
        return self.contents.pressure(self._now.volume) - self._model.outside

    def begin(self, time: float, dt: float) -> None:
        self._time, self._passing = time, dt
        self._space.press(self._now, self._gauge)

    def linearise(self) -> tuple[float, np.ndarray, np.ndarray]:
        self._clear()
        slope = self._nodes.volume_slope
        for body, areas in zip(self._on_grid, self._now.areas, strict=True):
            scatter_vectors(body.n_slabs, body.mapped, np.ascontiguousarray(areas[body.stored_array("id")]), slope)
        node = np.flatnonzero(slope.any(axis=1))
        return max(self.contents.stiffness(self._now.volume), 0.0), node, slope[node]

    def add_force(self, node: np.ndarray, force: np.ndarray) -> None:
        self._field.load_row(self._load)[node] += force

    @property
    def _on_grid(self) -> list[PointsOnGrid]:
        """The membranes that grid nodes move: all of them if the pressure is implicit."""
        return [body for body in self._space.bodies if isinstance(body, PointsOnGrid)]

    @property
    def _field(self) -> VelocityField:
        return self._on_grid[0].velocity_field

    def end(self, dt: float) -> None:
        """Exchange half of the mass that flows in and out in the step dt [s], update the volume, and exchange the other half.

        The work of the mean of the pressures at the start and the end of the step then equals the energy that the contents
        lose, to second order in the step.
        """
        before, contents, gauge = self._now, self.contents, self._gauge
        held, works = contents.energy, dict.fromkeys(("enclosed_heat", "inflator_energy", "vent_energy"), 0.0)
        self._vent_flow = self._leak_flow = self._hole_flow = 0.0
        self._flow(self._time, works)
        self._now = now = self._space.now()
        self._check(now)
        works["enclosed_heat"] += contents.expand(before.volume, now.volume)
        grown = now.volume - before.volume
        works["outside_work"] = self._model.outside * grown
        swept = before.swept(now) if self._space.is_open or now.hole > 0.0 else grown
        mean = 0.5 * (gauge + self._gauge)
        works["outside_work"] += mean * (grown - swept)  # on lids, which are supported otherwise, and in holes
        self._flow(self._time + 0.5 * self._passing, works)
        works["enclosed_energy"] = contents.energy - held
        self._works = works
        if dt > 0.0:
            self._count_power(before.swept(now) / dt)

    def _flow(self, time: float, works: dict[str, float]) -> None:
        """Exchange gas or liquid with the inflator and the outside for half a step, starting at `time` [s]; add the energies
        exchanged [J] to `works`, by the name of their channel (entry of the energy balance)."""
        if self._passing > 0.0:
            self._flow_in(time, 0.5 * self._passing, works)
            self._flow_out(0.5 * self._passing, works)

    def _flow_in(self, time: float, dt: float, works: dict[str, float]) -> None:
        if self._model.inflator is None:
            return
        mass, warmth = self._model.inflator.given(time, time + dt)
        if mass > 0.0:
            energy, heat = self.contents.take_in(mass, warmth, self._now.volume)
            works["inflator_energy"] += energy
            works["enclosed_heat"] += heat

    def _flow_out(self, dt: float, works: dict[str, float]) -> None:
        """Remove the contents that flow out in a time dt [s], with the flux at the middle of this time, at most until the
        outside pressure is reached. works: energies exchanged [J] by the name of their channel, increased here."""
        if self._gauge < 0.0 and self._now.hole > 0.0:
            self._flow_back(dt, works)
        if not (self._model.lets_out or self._now.hole > 0.0) or self.contents.mass == 0.0:
            return
        volume = self._now.volume
        self._open = [
            is_open or self._gauge >= vent.opens_at for is_open, vent in zip(self._open, self._model.vent, strict=True)
        ]
        area = self._space.membrane_area() - self._now.hole if self._model.leak > 0.0 else 0.0
        flows, excess = self._efflux(self.contents, area), self.contents.excess(volume, self._model.outside)
        mass = 0.5 * dt * sum(flows)
        if mass < excess:  # otherwise the outside pressure is reached within half of this time
            half = copy(self.contents)
            half.let_out(mass, volume)
            flows = self._efflux(half, area)
            mass = dt * sum(flows)
        mass = min(mass, max(excess, 0.0))
        energy, heat = self.contents.let_out(mass, volume)
        works["vent_energy"] += energy
        works["enclosed_heat"] += heat
        if (flow := sum(flows)) > 0.0:
            share = mass / self._passing / flow
            self._vent_flow += share * flows[0]
            self._leak_flow += share * flows[1]
            self._hole_flow += share * flows[2]

    def _flow_back(self, dt: float, works: dict[str, float]) -> None:
        """Add the outside fluid that flows in through holes in a time dt [s], at most until the outside pressure is
        reached. works: energies exchanged [J] by the name of their channel, increased here."""
        volume, outside = self._now.volume, self._model.outside
        most = self.contents.lack(volume, outside)
        mass = min(dt * self._now.hole * self.contents.influx(volume, outside), most)
        energy, heat = self.contents.draw_in(mass, volume)
        works["vent_energy"] -= energy
        works["enclosed_heat"] += heat
        self._hole_flow -= mass / self._passing

    def _efflux(self, contents: Contents, area: float) -> tuple[float, float, float]:
        """Return the mass flow rates [kg/s] of the contents to the outside: through vents, through the pores of the membrane
        with this area [m²], and through holes."""
        volume, outside = self._now.volume, self._model.outside
        gauge = contents.pressure(volume) - outside
        if gauge <= 0.0:
            return 0.0, 0.0, 0.0
        vents = zip(self._open, self._model.vent, strict=True)
        opening, hole = sum(vent.coefficient * vent.area for is_open, vent in vents if is_open), self._now.hole
        through_vents = opening * contents.efflux(volume, outside) if opening > 0.0 else 0.0
        through_holes = hole * contents.efflux(volume, outside) if hole > 0.0 else 0.0
        return through_vents, self._model.leak * area * gauge, through_holes

    def _count_power(self, growth: float) -> None:
        """Add half of the power of the gauge pressure on the membranes [W] to the sum `half_power` of the first body; the
        energy balance sums `half_power` over all bodies.

        growth: rate of change of the enclosed volume due to the motion of its membranes [m³/s].
        """
        self._space.bodies[0].totals.half_power += 0.5 * self._gauge * growth

    def added_stiffness(self) -> AddedStiffness:
        """Return the stiffness of the compressible contents, on which the membranes oscillate; none if their pressure is
        implicit."""
        stiffness = 0.0 if self._model.is_implicit else max(self.contents.stiffness(self._now.volume), 0.0)
        rate = 0.5 * sqrt(stiffness * self._space.mobility(self._now))
        return self._space.added_stiffness(rate, f"the enclosed `{self._model.name}`")

    def work(self) -> StepWork:
        done = self._layout.no_work()
        for channel in self._model.channels():
            done.works[self._layout.column(channel)] = amount = self._works.get(channel.name, 0.0)
            done.works[INTERNAL] -= channel.sign * amount  # work of the pressure in the energy of the contents
        return done

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return a warning about holes that failed points of the membrane leave."""
        now, model = self._now, self._model
        if not now.failed[0]:
            return {}
        text = (
            f"membrane {model.body} has failed at {now.failed[0]} of its {len(now.areas[0])} points: they leave holes of "
            f"{now.hole:.3g} m2, through which `{model.name}` flows out against the pressure outside, {model.outside:g} Pa"
        )
        return {"holes": text}

    def columns(self) -> Mapping[str, float]:
        volume, contents = self._now.volume, self.contents
        values: dict[str, float | None] = {
            "pressure": contents.pressure(volume),
            "gauge_pressure": self._gauge,
            "volume": volume,
            "mass": contents.mass,
            "temperature": contents.temperature,
            "vent_flow": self._vent_flow,
            "leak_flow": self._leak_flow,
            "hole_flow": self._hole_flow,
            "hole_area": self._now.hole,
        }
        shown = {f"{self._model.name}_{name}": value for name, value in values.items() if value is not None}
        return {name: shown[name] for name in self._model.columns()}

    def state_numbers(self) -> dict[str, Any]:
        flows: Sequence[float] = self._vent_flow, self._leak_flow
        state = {"mass": self.contents.mass, "energy": self.contents.energy, "open": list(self._open), "flows": list(flows)}
        return state | {"hole_flow": self._hole_flow}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self.contents.mass, self.contents.energy = numbers["mass"], numbers["energy"]
        self._open = list(numbers["open"])
        self._vent_flow, self._leak_flow = numbers["flows"]
        self._hole_flow = numbers.get("hole_flow", 0.0)
        self._now = self._space.now()
