"""Walls defined by the shape of a support or of a body whose motion is prescribed: fluids do not slip on the surface of the
shape itself.

A support that clamps the nodes in a region stops the fluid somewhere between the last clamped node and the next one. With
the walls of this module, the nodes near the surface are free along the surface, and in each step receive the traction of a
wall at the surface of the shape:

    J_i = -μ dt A_i (∂u/∂n - n n·∂u/∂n) ,    A_i = ∫ φ_i dA over the surface,

where u is the velocity profile that is zero on the surface and passes through the velocities of the fluid at two positions
on the normal (see `pellucid.conditions.rigid.no_slip`). The momentum that the fluid loses to the wall thus equals the
viscous flux of the profile, for any position of the surface between the nodes. No node near the surface has a prescribed
velocity along it, which would drag the fluid beyond. Nodes in the region and within half a cell of it have the velocity of
the wall normal to the surface. On the other nodes that the surface reaches, the wall exerts the pressure of the fluid, see
`pellucid.conditions.pressure_on_walls`. Points do not fill the last layer of cells: a node with less mass than fluid would
have in the part of its volume outside the region transfers the missing fraction of its impulse to its neighbours.

Edges: the velocity near a convex edge is singular, and no profile through two positions describes it. With the traction alone,
the fluid slips around the edge. On the surface beside edges, within half a cell, the slope therefore also contains γ u_s/h
along the surface, with the velocity u_s by which the fluid slips there and the cell size h:

    J_i = -μ dt γ/h ∫ φ_i (u - n n·u) dA ,    u = Σ_j φ_j u_j .

γ = 16 is the bound from which the method of Nitsche (1971) is coercive: the squared slope of a parabola at the end of an
element of length b is at most 4/b times its integral over the element (Warburton & Hesthaven 2003). Here b = h/2, and the two
faces at the edge share the element: γ/h = 2 · 4/b. Surfaces with a radius of curvature of more than two cells have no such
term. The areas of both faces are added, see `pellucid.conditions.areas`. Nodes near a membrane move with it, and not as the
fluid at the surface: a share e of a membrane in the mass of a node causes a false slope of up to γ e u/h, and the friction
would hold the membrane. The term is therefore multiplied by max(0, 1 - γ e), with the largest e of the nodes from which u_s is
interpolated. Transfers without affine fields map to the nodes at a wall the mean velocity of points beside it: in a plane shear
flow, u_s would be a third of a cell times the slope, and the term 5 to 6 times the traction. With these transfers there is no
such term.

The velocities at the two positions are reliable where fluid fills the nodes around them. On surfaces that are oblique to the
grid, some of these nodes lie in the wall. Each is therefore compared with the part of its volume outside all walls.

Several fluids, and fluids with a rheology: μ is the mean viscosity of the points around the node, by volume. Membranes in the
velocity field move with the fluid.

Implicit viscosity: J_i is the impulse at the velocities before the step. It changes in the step, and in long steps its
delay would be unstable. The node therefore also receives -dt w_i (u_i - u°_i) along the surface, with the velocity u°_i that
it had at the end of the last step and w_i = μ A_i/h for cells of size h. The solver takes this term and the prescribed normal
velocity into account. In a steady flow the term is zero. The velocities that the points map to the node would not do as u°_i:
the transfers smooth the velocities of nodes in the wall, and the term would then push the fluid with 2 to 5 % of the traction
in a gap of four cells.

Bodies: the points of a body that acts as a wall have grid nodes of their own, so that fluids do not share momentum with them.
The wall is the region that the body fills, moved with its points; its velocity is V + ω × (x - c) at the position x. It is
found again when its surface has moved along the normal. Space behind a body that no fluid can reach counts as part of it, so
that a wall around a fluid may be thin. The motions of the body receive the reaction.

Several supports whose shapes touch and which hold the same axes make one wall, see `pellucid.conditions.walls_of_supports`.

Requirements of supports: material points of viscous fluids; a velocity field that they share at most with rigid bodies and
membranes; a support that does not end. A support that holds only some axes stops and drags fluids along these. Near a rigid
body the nodes of the region are clamped as in other cases, so that the body does not sink in. The fluid at free surfaces and
next to walls thinner than about a cell is also stopped.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from pellucid.conditions.areas import BESIDE_EDGES
from pellucid.conditions.narrow_layers import IsInWall, NarrowLayers, face_walls
from pellucid.conditions.nodal_fluid import Bodies, NodalFluid, sorted_bodies
from pellucid.conditions.pressure_on_walls import FluidAtNodes, WallPressure, inner_axes
from pellucid.conditions.rigid.no_slip import NoSlip
from pellucid.conditions.wall_surface import CutNodes, WallMaker, find_wall
from pellucid.conditions.walls_of_bodies import BodyAsWall, EnclosedFluids, find_region
from pellucid.conditions.walls_of_supports import Part, SupportsAsWall, walls_of_supports
from pellucid.energy import IMPACT, StepWork, WorkLayout
from pellucid.geometry.region import within
from pellucid.geometry.shapes.rotation import Turn
from pellucid.grid.actions import NodalActions
from pellucid.grid.nodal_conditions import MASS_EPS
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.parts.assembly import Assembly
from pellucid.ranks.domain import domain
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

SLIP = 2 * 4 / BESIDE_EDGES  # γ above
RIGID_REACH = 2  # cells around the points of rigid bodies within which nodes stay held


class FluidWall(WallMaker, Protocol):
    """Interface of supports or a body that make a wall: its region, its velocity, and the account of its reaction."""

    name: str
    """Name in messages."""
    slips: bool
    """True if fluids slip on the surface."""

    def velocity_at(self, place: np.ndarray) -> np.ndarray:
        """Return the velocities of the wall at positions [m], shape (n, 3), one for each node near the surface, continued
        rigidly beyond the surface: shape (n, 3), or (3,) if it is uniform [m/s]."""

    def account(self, impulse: np.ndarray, place: np.ndarray, layout: WorkLayout) -> StepWork:
        """Return the reaction of the wall and its work. impulse: impulses of the wall on the fluid [N s] at the positions
        `place` [m], shape (n, 3) each, which the velocity field counted as external; layout: order of the works."""


class EndVelocities(NamedTuple):
    """Velocities at the end of a step, of nodes that had mass."""

    node: np.ndarray  # (m,) numbers of the nodes, ascending
    velocity: np.ndarray  # (m, 3) [m/s]

    def replace_in(self, values: np.ndarray, node: np.ndarray) -> np.ndarray:
        """Return velocities `values` [m/s], shape (n, 3), of nodes with the ascending numbers `node`, shape (n,), with those
        replaced that are known from the last step."""
        _, to, known = np.intersect1d(node, self.node, assume_unique=True, return_indices=True)
        found = values.copy()
        found[to] = self.velocity[known]
        return found


class NoSlipWall(StepPart):
    """Active condition of the no-slip wall that a body or supports that touch make in one velocity field: fluid does not slip
    on the surface of its region, wherever the surface lies between the nodes."""

    def __init__(
        self,
        actions: NodalActions,
        maker: FluidWall,
        bodies: Bodies,
        fluid: NodalFluid,
        faces: "Sequence[Support]",
        others: Sequence[BodyAsWall],
        assembly: Assembly,
    ) -> None:
        """actions: actions on the nodes of the velocity field; maker: supports or body that make the wall; bodies: bodies in
        the velocity field; fluid: mass and viscosity of its fluids at the nodes; faces: all supports, split so that each acts
        on at most one face; others: all bodies that act as walls on these fluids."""
        self._actions, self._maker, self._rigid, self._layout = actions, maker, bodies.rigid, assembly.layout
        self._field, self._faces, self._others = actions.field, faces, others
        self._fluid, self._no_slip = fluid, NoSlip(actions.field.grid)
        self._delays = any(fluid.solves_viscosity for fluid in bodies.fluids)
        self.name, self.slips, self._axes = maker.name, maker.slips, np.array(maker.axes, float)
        self._ended = EndVelocities(np.zeros(0, int), np.zeros((0, 3)))
        self.find()

    def find(self) -> None:
        """Find the nodes near the surface, for the present place of the region."""
        self._wall = wall = find_wall(self._no_slip, self._actions, self._maker, self._faces, self._others)
        self._marks = self._field.grid.nodes.constrained[wall.node].copy()
        self._in_window = np.searchsorted(wall.window.node, wall.node)
        room = self._field.grid.cell_volume * wall.share * (1.0 - wall.filled)
        self._pressure = WallPressure(wall.node, wall.into, room, inner_axes(self._field.grid, wall.place))
        self._acts, self._taken = np.zeros(len(wall.node), bool), np.zeros((len(wall.node), 3))
        if isinstance(self._maker, BodyAsWall):
            self._maker.stand(wall.feet[wall.known], wall.surface.normal[wall.known])
        elif isinstance(self._maker, SupportsAsWall):
            self._maker.find_owners(wall.place, wall.feet, wall.surface.normal)

    @property
    def cut(self) -> CutNodes:
        return self._wall.cut

    @property
    def stands(self) -> bool:
        return len(self._maker.rows) > 0

    def fills(self, place: np.ndarray) -> np.ndarray:
        grid = self._field.grid
        return within(self._maker.region, place, grid.active_axes, grid.periods)

    def restore_marks(self) -> None:
        """Let the support constrain the nodes again that the wall freed."""
        self._field.grid.nodes.constrained[self._wall.node] = self._marks

    @property
    def acts_anywhere(self) -> bool:
        """True if there are nodes near the surface, on which the wall can act, or may come near it."""
        return len(self._wall.node) > 0 or not self._maker.rows

    def begin(self, time: float, dt: float) -> None:
        """Free the nodes near the surface, which the support constrains, for this step; nodes near rigid bodies stay
        constrained."""
        wall, constrained = self._wall, self._field.grid.nodes.constrained
        self._acts[:] = ~self._near_rigid()
        node, axis = np.nonzero(wall.released)
        constrained[wall.node[node], axis] = np.where(self._acts[node], 0, self._marks[node, axis])

    def _near_rigid(self) -> np.ndarray:
        """Return a mask of the wall's nodes that lie near points of rigid bodies, so that rigid bodies may contribute to
        these nodes, shape (n,)."""
        grid, reached = self._field.grid, np.zeros(len(self._wall.node), bool)
        cell, thin = grid.lattice.cell, np.array(grid.thin)
        periods = np.array(grid.periods)
        place = np.where(thin, 0.0, grid.find_positions(self._wall.node))
        for member in self._rigid:
            points = np.where(thin, 0.0, domain.whole(member.body.arrays["position"]))
            middle, half = 0.5 * (points.min(axis=0) + points.max(axis=0)), 0.5 * np.ptp(points, axis=0)
            off = place - middle
            off -= periods * np.round(off / np.where(periods > 0.0, periods, np.inf))
            close = np.flatnonzero(np.all(np.abs(off) <= half + RIGID_REACH * cell, axis=1))
            if not len(close):
                continue
            cells = np.unique(np.rint((points - middle) / cell).astype(int), axis=0)
            for k in close:
                reached[k] |= bool(np.any(np.all(np.abs(cells * cell - off[k]) <= (RIGID_REACH + 0.5) * cell, axis=1)))
        return reached

    def before_momentum(self, dt: float) -> None:
        """Find the impulses of the surface traction over the step dt [s], from the velocities before the step."""
        wall, nodes, no_slip = self._wall, self._field.grid.nodes, self._no_slip
        window, at, velocity_at = wall.window, wall.node, self._maker.velocity_at
        self._velocity = velocity_at(wall.place)
        self._across = wall.across * self._acts[:, None]
        if self.slips:
            self._mass = domain.of_nodes(nodes.mass[at], at)
            self._old = self._lag = np.zeros((len(at), 3))
            self._drag = self._push(dt)
            self._yields = self._yielding(wall.surface.certainty)
            return
        of_window, momentum = (domain.of_nodes(values[window.node], window.node) for values in (nodes.mass, nodes.momentum))
        old = np.where(of_window[:, None] > MASS_EPS, momentum / np.maximum(of_window, MASS_EPS)[:, None], 0.0)
        constrained, supports = nodes.constrained[window.node], self._actions.supports
        mirrored = (constrained > 0) & (supports.mirror[constrained - 1] != 0)
        old[mirrored] = supports.velocity[(constrained - 1)[mirrored], np.nonzero(mirrored)[1]]
        self._old, self._mass = self._ended.replace_in(old[self._in_window], at), of_window[self._in_window]
        fluid = self._fluid.masses(window.node)
        open_share = self._fluid.open_shares(window.node)
        near, near_known, full = no_slip.sample_as_points(window, old, fluid, open_share, wall.samples[0])
        far, far_known, _ = no_slip.sample_as_points(window, old, fluid, open_share, wall.samples[1])
        places = [wall.feet + height[:, None] * wall.surface.normal for height in wall.heights]
        opposite = wall.opposite
        for number, body in enumerate(self._others):
            facing = (wall.opposite_body == number)[:, None]
            opposite = np.where(facing, body.velocity_at(places[1]), opposite)
        far = np.where(wall.facing[:, None], opposite, far * wall.signs[1]) - velocity_at(places[1])
        near, far_known = near * wall.signs[0] - velocity_at(places[0]), np.where(wall.facing, 1.0, far_known)
        sure = wall.surface.certainty * near_known
        self._yields = self._yielding(sure)
        slope = no_slip.slope_of_profile(wall.surface._replace(certainty=sure), near, far, far_known, wall.heights)
        viscosity = self._fluid.viscosities(at)
        per_slope = viscosity * dt * wall.area * self._acts
        drag = -per_slope[:, None] * slope * self._axes
        self._drag = self._keep_from_light(drag, fluid[self._in_window], full) + self._push(dt)
        rate = SLIP * viscosity * dt / self._field.grid.lattice.cell * self._acts
        known = self._known_at_edges(of_window, fluid)
        of_slip = rate * (wall.slip.to_nodes @ known)
        if not self._delays:  # at most the impulse that stops the node
            rate = rate * self._mass / np.maximum(self._mass + of_slip, MASS_EPS)
        old[self._in_window] = self._old
        self._drag -= rate[:, None] * self._slip_at_edges(old, known) * self._axes
        lag = per_slope * sure / self._field.grid.lattice.cell + of_slip
        self._lag = (self._delays * lag)[:, None] * self._axes

    def _known_at_edges(self, mass: np.ndarray, fluid: np.ndarray) -> np.ndarray:
        """Return the parts of the pieces of the edges, shape (m,), at which the interpolated velocity is that of the fluid: 1
        without membranes, and 0 without affine fields and where γ e reaches 1 with the largest share e of membranes at its
        nodes. mass, fluid: masses of the nodes of the window and of fluids there [kg]."""
        slip, window = self._wall.slip, self._wall.window
        if not self._fluid.is_affine:
            return np.zeros(len(slip.normal))
        if self._fluid.is_alone or not len(slip.normal):
            return np.ones(len(slip.normal))
        others = 1.0 - np.divide(fluid, mass, out=np.ones(len(mass)), where=mass > MASS_EPS)
        around = others[window.place].ravel()[slip.at_edges.indices]
        return np.asarray(np.maximum(0.0, 1.0 - SLIP * np.maximum.reduceat(around, slip.at_edges.indptr[:-1])))

    def _slip_at_edges(self, velocity: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Return the velocities along the surface with which the fluid slips at the edges, times the areas of the edges at
        nodes [m³/s], shape (n, 3). velocity: of the window [m/s]; known: result of `_known_at_edges`."""
        slip = self._wall.slip
        if not len(slip.normal):
            return np.zeros((len(self._wall.node), 3))
        fluid = self._no_slip.continued(self._wall.window, velocity).reshape(-1, 3)
        found = slip.at_edges @ fluid - slip.of_wall @ np.broadcast_to(self._velocity, (len(self._wall.node), 3))
        along = found - np.sum(found * slip.normal, axis=1)[:, None] * slip.normal
        return np.asarray(slip.to_nodes @ (known[:, None] * along))

    def _yielding(self, sure: np.ndarray) -> np.ndarray:
        """Return the part of their velocities relative to the wall that nodes keep, shape (n, 3): less than 1 for nodes of the
        region for which distance and normal are not reliable; sure: their reliability, between 0 and 1, shape (n,)."""
        return 1.0 - self._axes * np.where(self._wall.held & self._acts, 1.0 - sure, 0.0)[:, None]

    def _push(self, dt: float) -> np.ndarray:
        """Return the impulses of the pressure of the wall over the step dt [s] on the nodes [N s], shape (n, 3); without the
        part along which a node does not move relative to the wall."""
        push = dt * self._pressure.forces(self._fluid.at_walls) * self._axes * self._acts[:, None]
        return np.asarray(push - np.sum(push * self._across, axis=1)[:, None] * self._across)

    def constrain(self, rows: ViscousRows) -> None:
        """Take the wall into account in the equations of implicit viscosity: masses, initial velocities and velocities without
        viscosity of the nodes; see `pellucid.grid.implicit_viscosity`."""
        at = self._wall.node
        inertia, target, solution, normal = (
            values.reshape(-1, 4) for values in (rows.inertia, rows.target, rows.solution, rows.normal)
        )
        free = (inertia[at, :3] > 0.0) & (self._acts & (self._mass > MASS_EPS))[:, None]
        across = np.where(free, self._across, 0.0)
        size = np.linalg.norm(across, axis=1)[:, None]
        across = np.divide(across, size, out=np.zeros_like(across), where=size > 0.0)
        more = inertia[at, :3] + self._lag
        aim = (inertia[at, :3] * target[at, :3] + self._drag + self._lag * self._old) / np.maximum(more, MASS_EPS)
        yields = self._yields
        aim = self._velocity + yields * (aim - self._velocity)
        more = np.divide(more, yields, out=np.zeros_like(more), where=yields > 0.0)
        start = np.where(yields > 0.0, solution[at, :3], self._velocity)
        for values, new in ((target, aim), (solution, start)):
            lacks = self._velocity - new
            new = new + np.sum(lacks * across, axis=1)[:, None] * across
            values[at, :3] = np.where(free, new, values[at, :3])
        inertia[at, :3] = np.where(free, more, inertia[at, :3])
        normal[at, :3] = across

    def act_on_nodes(self, dt: float) -> None:
        """Apply the impulses of the surface traction to the fluid, and give the nodes of the region the wall's velocity along
        the normal."""
        nodes, at, mass, across = self._field.grid.nodes, self._wall.node, self._mass[:, None], self._across
        velocity = domain.of_nodes(nodes.velocity[at], at)
        lacks = self._velocity - velocity
        normal = np.sum(lacks * across, axis=1)[:, None] * across
        drag = self._drag + self._lag * (self._old - velocity)
        drag *= mass / np.maximum(mass + self._lag, MASS_EPS)
        yields = self._yields
        impulse = (1.0 - yields) * mass * (lacks - normal) + (yields if self._delays else 1.0) * drag
        if self._delays:  # along the surface, as the solver assumed
            impulse -= np.sum(impulse * across, axis=1)[:, None] * across
        taken = self._field.add_impulses(mass * normal + impulse, IMPACT, -1.0, at)
        strain, stopped = nodes.strain_velocity, across.any(axis=1)
        strain[at] += np.sum((self._velocity - strain[at]) * across, axis=1)[:, None] * across
        self._field.strain_as_moved(at[stopped])
        self._taken = domain.of_nodes(taken, at)

    def _keep_from_light(self, impulse: np.ndarray, mass: np.ndarray, full: np.ndarray) -> np.ndarray:
        """Return the impulses on the nodes [N s], shape (n, 3), after nodes whose volume is only partly filled by points
        have passed a part of their impulse to their neighbours. impulse: before [N s], shape (n, 3); mass: of the fluid at
        the nodes [kg], shape (n,); full: mass of a node full of fluid [kg], shape (n,)."""
        wall = self._wall
        share = np.minimum(1.0, mass / np.maximum(full * wall.share * (1.0 - wall.filled), MASS_EPS))
        weights = wall.neighbours * np.where(self._acts, mass, 0.0)
        total = weights.sum(axis=1)
        rest = np.where(total > MASS_EPS, 1.0 - share, 0.0)[:, None] * impulse
        return np.asarray(impulse - rest + weights.T @ (rest / np.maximum(total, MASS_EPS)[:, None]))

    def end(self, dt: float) -> None:
        if self._delays and not self.slips:
            nodes, at = self._field.grid.nodes, self._wall.node
            has_mass = domain.of_nodes(nodes.mass[at], at) > MASS_EPS
            self._ended = EndVelocities(at[has_mass], domain.of_nodes(nodes.velocity[at], at)[has_mass])

    def state_arrays(self) -> dict[str, np.ndarray]:
        found = self._pressure.found
        ended = {"node": self._ended.node, "velocity": self._ended.velocity} if self._delays and not self.slips else {}
        return ended if found is None else ended | found._asdict()

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        if self._delays and not self.slips:
            self._ended = EndVelocities(arrays["node"], arrays["velocity"])
        self._pressure.found = FluidAtNodes(*(arrays[name] for name in FluidAtNodes._fields)) if "ends" in arrays else None

    def work(self) -> StepWork:
        """Return the reaction of the wall and its work; the impulse is counted as a reaction of the support or of the motions
        of the body instead of an external impulse of the velocity field."""
        return self._maker.account(self._taken, self._wall.place, self._layout)


class MovingWalls(StepPart):
    """The walls of one velocity field of which at least one is a body. All walls are found again when the surface of a body has
    moved, since walls act on each other's nodes."""

    def __init__(
        self, walls: Sequence[NoSlipWall], bodies: Sequence[BodyAsWall], enclosed: EnclosedFluids, fluid: NodalFluid
    ) -> None:
        self._walls, self._bodies, self._enclosed, self._fluid = walls, bodies, enclosed, fluid
        self._name = f"turns of {enclosed.name}"

    def begin(self, time: float, dt: float) -> None:
        found = [body.find_turn() for body in self._bodies]
        if any(turn is not None for turn in found):
            self._move([body.turn if turn is None else turn for body, turn in zip(self._bodies, found, strict=True)])

    def before_momentum(self, dt: float) -> None:
        for body in self._bodies:
            body.begin_step()

    def _move(self, turns: Sequence[Turn]) -> None:
        for wall in self._walls:
            wall.restore_marks()
        for body, turn in zip(self._bodies, turns, strict=True):
            body.move(turn)
        self._enclosed.fill_behind(self._bodies)
        for wall in self._walls:
            wall.find()
        self._fluid.leave_out([wall.cut for wall in self._walls])

    def state_numbers(self) -> dict[str, Any]:
        return {self._name: [[part.tolist() for part in body.turn] for body in self._bodies]}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._move([Turn(*(np.array(part) for part in turn)) for turn in numbers[self._name]])


def no_slip_walls(supports: "Sequence[Support]", assembly: Assembly) -> list[StepPart]:
    """Return the active walls in all velocity fields with suitable bodies, and before them what they need of the fluids;
    supports: all supports, split so that each acts on at most one face."""
    found: list[StepPart] = []
    for actions in assembly.actions:
        members = [member for member in assembly.bodies.values() if member.actions is actions]
        models, bodies, name = [member.model for member in members], sorted_bodies(members), actions.field.name
        parts = [
            Part(row, one, shape.geometry())
            for row, one in enumerate(supports)
            if one.acts_as_wall_among(models) and (shape := one.wall_of_fluids()) is not None
        ]
        makers: list[FluidWall] = [*walls_of_supports(parts, actions)]
        led = [
            BodyAsWall(member, region, actions)
            for member in assembly.bodies.values()
            if member.model.is_wall and member.model.field == name
            if (region := find_region(member, actions.field.grid)) is not None
        ]
        holding: list[tuple[str, IsInWall]] = []
        if makers or led:
            fluid, shapes = NodalFluid(bodies, actions), [maker.region for maker in makers]
            enclosed = EnclosedFluids(name, actions.field.grid, shapes, bodies.fluids)
            enclosed.fill_behind(led)
            walls = [NoSlipWall(actions, maker, bodies, fluid, supports, led, assembly) for maker in (*makers, *led)]
            walls = [wall for wall in walls if wall.acts_anywhere]
            if walls:
                fluid.leave_out([wall.cut for wall in walls])
            actions.field.walls = walls
            holding += [(wall.name, wall.fills) for wall in walls if not wall.slips]
            found += [*([MovingWalls(walls, led, enclosed, fluid)] if led else []), fluid, *walls] if walls else []
        membranes = [member for member in members if member.model.is_surface]
        if membranes and any(model.is_fluid and model.shear_viscosity > 0.0 for model in models):
            found.append(NarrowLayers(membranes, [*holding, *face_walls(supports, actions)], actions))
    return found
