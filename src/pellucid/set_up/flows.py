"""Warnings about flows: no outlet, vents that never open, absorbing faces without effect, liquids that slip along bodies."""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.bodies.material_points.checks import meets_after_solve
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.membranes.model import MembraneCase
from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.bodies_as_walls import is_led, is_thin
from pellucid.conditions.enclosed.foretold import membrane_at_start
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.conditions.open_faces.columns import OpenFace, opening_of
from pellucid.conditions.open_faces.inflow import Inflow
from pellucid.conditions.outflow import Outflow
from pellucid.conditions.support import Support
from pellucid.findings import listed
from pellucid.geometry.shapes.contract import AXES
from pellucid.materials.contract import PointMaterial
from pellucid.materials.fluid import FluidMaterial
from pellucid.parts.condition import Condition
from pellucid.step.limit import spread_in_cells

SQUEEZED = 0.02  # of the volume of a liquid, which its compression may take up
VACUUM = 1e-6  # density, in that at the start, whose pressure is the lowest of an equation of state
INSTANTS = 1001  # at which the volume that has come in is known


def flow_warnings(case: Case) -> Iterator[str]:
    """Yield warnings about inflows without an outlet and about openings that have no effect."""
    yield from _without_way_out(case)
    yield from _absorbing_at_inflows(case)
    yield from _profiles_without_effect(case)
    yield from _impossible_tensions(case)
    yield from _closed_vents(case)
    yield from _stopped_before_bodies(case)


def _stopped_before_bodies(case: Case) -> Iterator[str]:
    """Yield a warning for each body whose prescribed motion stops a fluid before its surface, since it is thin or other solids
    share the velocity field; otherwise it would be a wall. Membranes are not reported: bodies that move push them."""
    x, y, z = case.thin
    active = (not x, not y, not z)
    for body in case.body:
        together = [other for other in case.body if other.field == body.field]
        fluids = [other.name for other in together if other.shear_viscosity > 0.0]
        if not fluids or body.is_rigid or body.is_wall or not is_led(body, case.motion, active):
            continue
        others = listed([o.name for o in together if not (o.shear_viscosity > 0.0 or is_led(o, case.motion, active))])
        thin = listed([o.name for o in together if is_led(o, case.motion, active) and is_thin(o, case.body, case.grid)])
        why = f"{others} shares their velocity field" if others else f"{thin} is thinner than a cell"
        remedy = f"Set another `field` for {others}" if others else f"Use a smaller grid.cell, or make {thin} thicker"
        if not any(other.is_surface for other in together):
            yield (
                f"{listed(fluids)} stops up to a cell before the surface of body {body.name}, whose motion is prescribed, "
                f"because {why}. {remedy}, or set `rigid = true` for {body.name}, with `hold_rotation` in its motion and "
                'time.transfer = "apic".'
            )


def _label(what: str, name: str | None, number: int) -> str:
    return f"{what} `{name}`" if name else f"{what} number {number + 1}"


def _absorbing_at_inflows(case: Case) -> Iterator[str]:
    """Yield a warning for each absorbing face at which an inflow prescribes the velocity."""
    parts = parts_of(case)
    for number, absorbing in enumerate(parts.of(Absorbing)):
        for other, inflow in enumerate(parts.of(Inflow)):
            if inflow.where in absorbing.where and inflow.through is None and inflow.pressure is None:
                label = _label("inflow", inflow.name, other)
                yield (
                    f"absorbing number {number + 1} has no effect at the face {inflow.where}: {label} prescribes the "
                    "velocity of this face and reflects waves. Remove the face from `where` of the [[absorbing]]."
                )


def _profiles_without_effect(case: Case) -> Iterator[str]:
    """Yield a warning for each inflow under a pressure that has a velocity profile."""
    for number, inflow in enumerate(parts_of(case).of(Inflow)):
        if inflow.pressure is not None and inflow.profile != "uniform":
            yield (
                f"{_label('inflow', inflow.name, number)}: `profile` has no effect with `pressure`: the velocity profile "
                "results from the flow, also when it reverses. Remove `profile`."
            )


def _impossible_tensions(case: Case) -> Iterator[str]:
    """Yield a warning for each pressure at a face that falls below the lowest pressure of a liquid there."""
    from pellucid.materials.eos.equation import pressure_line

    parts = parts_of(case)
    materials = {body.name: body.material for body in case.body if isinstance(body, SeededBody)}
    liquids = {name: one for name, one in materials.items() if isinstance(one, FluidMaterial) and one.is_liquid}
    ins, outs = enumerate(parts.of(Inflow)), enumerate(parts.of(Outflow))
    flows: list[tuple[str, Inflow | Outflow, Sequence[str]]] = [
        *((_label("inflow", flow.name, number), flow, [flow.body]) for number, flow in ins),
        *((_label("outflow", flow.name, number), flow, flow.body) for number, flow in outs),
    ]
    for label, flow, names in flows:
        least = min(share * (flow.pressure or 0.0) for share in flow.extreme_shares())
        for name, liquid in liquids.items():
            lowest = pressure_line(liquid.law().eos, VACUUM * liquid.density)[0]
            if least < lowest and (not names or name in names):
                yield (
                    f"{label}: its pressure falls to {least:.4g} Pa, but a pressure of body {name} cannot be below "
                    f"{lowest:.4g} Pa by its equation of state: it would expand without limit. Set a larger `eos.sound_speed`, "
                    "or a higher pressure."
                )


def _without_way_out(case: Case) -> Iterator[str]:
    """Yield a warning for each liquid that cannot leave the grid and whose inflows add more volume than the grid has room
    for."""
    parts, grid = parts_of(case), case.grid_or_none
    if grid is None or any(one.gas is not None for one in parts.of(Enclosed)):
        return
    inflows = list(enumerate(parts.of(Inflow)))
    for body in case.body:
        own = [(number, inflow) for number, inflow in inflows if inflow.body == body.name]
        if not own or not isinstance(body, SeededBody) or not _is_liquid(body):
            continue
        gives_way = any(isinstance(other, SeededBody) and other.material.flows and not _is_liquid(other) for other in case.body)
        leaves = any(body.name in outflow.body or not outflow.body for outflow in parts.of(Outflow))
        if gives_way or leaves or any(inflow.pressure is not None for _, inflow in own) or not _is_closed(case):
            continue
        times = np.linspace(0.0, case.time.end, INSTANTS)
        entered = np.sum([_entered(inflow, body, case, times) for _, inflow in own], axis=0)
        room = max(_grid_volume(case) - sum(_volume(other, case) for other in case.body if not other.is_surface), 0.0)
        late = np.flatnonzero(entered > room + SQUEEZED * _volume(body, case))
        if len(late):
            label = _label("inflow", own[0][1].name, own[0][0])
            yield (
                f"{label} adds {entered[-1]:.3g} m³ of body {body.name} until time.end, but only {room:.3g} m³ of the "
                "grid are empty "
                "and no liquid can leave: all other faces have supports and none has an [[outflow]]. The liquid is compressed "
                f"from {times[late[0]]:.2g} s on. Replace the support of a face by an [[outflow]], or set an earlier time.end."
            )


def _is_liquid(body: SeededBody) -> bool:
    return isinstance(body.material, FluidMaterial) and body.material.is_liquid


def _is_closed(case: Case) -> bool:
    """Return True if every face of the grid has a support for its normal velocity or an inflow or outflow.

    Faces on periodic axes, and on axes along which the grid is one cell thick, are ignored.

    """
    conditions = list(parts_of(case).of(Condition))
    for axis, thin in zip(AXES, case.thin, strict=True):
        if thin or axis in case.grid.periodic:
            continue
        for face in (f"{axis}-lower", f"{axis}-upper"):
            if not any(one.face_velocity(face) is not None or one.opens_face(face) for one in conditions):
                return False
    return True


def _entered(inflow: Inflow, body: SeededBody, case: Case, times: np.ndarray) -> np.ndarray:
    """Return the volume that an inflow of a body has added until the given times [m³]; same shape as `times` [s]."""
    rate = inflow.flow_rate
    if rate is None:
        face = OpenFace.of(inflow.where, case.grid)
        opening, _ = opening_of(inflow.through, face, body.with_others(case.body), case.grid)
        rate = (inflow.velocity or 0.0) * float(opening.area.sum())
    shares = np.array([inflow.share(float(time)) for time in times])
    steps = 0.5 * (shares[1:] + shares[:-1]) * np.diff(times)
    return np.asarray(rate * np.concatenate([[0.0], np.cumsum(steps)]))


def _grid_volume(case: Case) -> float:
    thin = sum(case.thin)
    return float(np.prod(case.grid.counts())) * case.grid.cell ** (3 - thin) * case.grid.slice_thickness() ** thin


def _volume(body: object, case: Case) -> float:
    """Return the volume of a body of material points without the bodies listed in its key `outside` [m³]; 0 for other
    bodies."""
    if not isinstance(body, SeededBody):
        return 0.0
    x, y, z = (not thin for thin in case.thin)
    measure = body.occupied().measure((x, y, z))
    measure -= sum(other.measure((x, y, z)) for other in body.with_others(case.body).excluded)
    return float(max(measure, 0.0) * case.grid.slice_thickness() ** sum(case.thin))


def _closed_vents(case: Case) -> Iterator[str]:
    """Yield a warning for each vent whose opening pressure the gas or liquid in the membrane cannot reach, if nothing
    compresses it."""
    parts, bodies = parts_of(case), {body.name: body for body in case.body}
    quiet = all(
        isinstance(one, Enclosed) or (isinstance(one, Support) and not any(one.velocity)) for one in parts.of(Condition)
    )
    if not quiet or any(case.gravity) or len(bodies) > 1:
        return
    for enclosed in parts.of(Enclosed):
        membrane = bodies[enclosed.body]
        start = membrane_at_start(membrane)
        if start is None or enclosed.inside or not _is_at_rest(membrane):
            continue
        contents = enclosed.amount().contents(start.volume)
        if enclosed.inflator is not None:
            contents.take_in(*enclosed.inflator.given(0.0, case.time.end), start.volume)
        most = contents.pressure(start.volume) - enclosed.outside
        brought = "" if enclosed.inflator is None else ", including the gas of the inflator until time.end"
        for number, vent in enumerate(enclosed.vent):
            if vent.opens_at > most:
                yield (
                    f"vent number {number + 1} of enclosed `{enclosed.name}` never opens: opens_at = {vent.opens_at:g} Pa "
                    f"above the outside pressure, but in the initial volume the excess pressure is at most {most:.4g} Pa"
                    f"{brought}. Set a smaller `opens_at`, or remove it for a vent that is always open."
                )


def _is_at_rest(membrane: object) -> bool:
    """Return True if a membrane has neither an initial velocity nor initial tension or inflation, so that it does not
    shrink."""
    is_slack = isinstance(membrane, MembraneCase) and membrane.tension == 0.0 and membrane.inflation == 0.0
    return is_slack and not (any(membrane.velocity) or membrane.initial)  # type: ignore[attr-defined]


def slipped_past(case: Case) -> Iterator[str]:
    """Yield a warning for each fluid with implicit viscosity in contact with rigid bodies or with moving bodies of other
    velocity fields: viscosity is solved before this contact, so that the fluid slips along these bodies if the time steps
    are long."""
    for fluid in case.body:
        material = getattr(fluid, "material", None)
        if fluid.implicit_stress is None or not isinstance(material, PointMaterial):
            continue
        mu, lam, *_ = material.implicit_stress() or (0.0, 0.0)
        step = spread_in_cells(case.grid.cell, (2.0 * mu + lam) / material.density).step
        after = [other.name for other in case.body if meets_after_solve(other, fluid)]
        if after:
            text = f"the implicit viscosity of body {fluid.name} is solved before the contact with {listed(after)}"
            remedy = (
                f"Set a shorter `time.step`, or place {listed(after)} in the velocity field of {fluid.name} and prescribe a "
                "[[motion]]"
            )
            yield f"{text}: with time steps much longer than {step:.2g} s the fluid slips along these bodies. {remedy}."
