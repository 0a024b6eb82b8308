"""Work of a step: the columns of work from the kernels to `history.csv`, and the channels that name them.

Every kernel that does work for a cause adds this work [J] to the column of the cause in a row of works. The first columns
belong to the kernels of the nodes, the remaining columns to the conditions of the run, see `WorkLayout`.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.errors import UnknownName
from pellucid.findings import absent

INTERNAL, GRAVITY, SUPPORT, MOTION, CONTACT, ABSORBED, IMPACT, DAMPING, VISCOUS, TRANSFER, FRICTION, FIRST_LOAD = range(12)
"""Columns of a row of works that the kernels of nodes and bodies fill. INTERNAL is the work of internal forces, which
exchange kinetic and stored energy. The columns from FIRST_LOAD on belong to the channels of external forces."""


class Channel(NamedTuple):
    """A cause of external work or loss, i.e. an entry of the energy balance: name of its column in the history, and sign
    with which the work enters the balance. Conditions and bodies declare their channels."""

    name: str  # column of `history.csv`, ending in `_work`, `_heat` or `_energy`
    sign: float = 1.0  # 1: energy that enters the bodies; -1: that leaves them; 0: exchange between entries of the balance


GRAVITY_WORK, SUPPORT_WORK, MOTION_WORK, CONTACT_WORK = map(
    Channel, ("gravity_work", "support_work", "motion_work", "contact_work")
)
ABSORBED_ENERGY, IMPACT_HEAT, DAMPING_HEAT, VISCOUS_HEAT, TRANSFER_HEAT, FRICTION_HEAT = (
    Channel(name, -1.0)
    for name in ("absorbed_energy", "impact_heat", "damping_heat", "viscous_heat", "transfer_heat", "friction_heat")
)
ENCLOSED_WORK = Channel("enclosed_work", 0.0)
"""Work of gases and liquids on the membranes that enclose them. Like the work of internal forces, it is an exchange within
the balance: the energy lost by the gas or liquid is another entry, and is subtracted in INTERNAL."""
SURFACE_TENSION_WORK = Channel("surface_tension_work", 0.0)
"""Work of surface tension on fluids, an exchange within the balance like `ENCLOSED_WORK`."""
SURFACE_ENERGY = Channel("surface_energy", -1.0)
"""Increase of the surface energy of fluids since the start."""
FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT = Channel("fluid_viscous_heat", 0.0), Channel("implicit_viscous_heat", 0.0)
"""Heat of fluids with implicit viscosity, as part of their internal energy: the dissipation of the velocities that were
solved for, and the additional loss of the implicit step, with that of an implicit pressure. Both are subtracted in INTERNAL."""
OUTFLOW_ENERGY = Channel("outflow_energy", -1.0)
"""Energy of points that left through a face of the grid. It is not work of a step: the balance adds it after the points
left."""
INFLOW_ENERGY = Channel("inflow_energy")
"""Energy of points that entered through a face of the grid. The balance adds it after the points entered."""
MASS_MATRIX_WORK = Channel("mass_matrix_work")
"""Work of the impulses that replace the lumped masses of the nodes by the consistent mass matrix: energy of the affine fields
of points, beyond that of the motion of the points."""
INFLOW_WORK, OUTFLOW_WORK = Channel("inflow_work"), Channel("outflow_work")
"""Work of the prescribed flow at open faces, and work of the pressure there."""
FIXED_COLUMNS: Mapping[Channel, int] = {
    GRAVITY_WORK: GRAVITY,
    SUPPORT_WORK: SUPPORT,
    MOTION_WORK: MOTION,
    CONTACT_WORK: CONTACT,
    ABSORBED_ENERGY: ABSORBED,
    IMPACT_HEAT: IMPACT,
    DAMPING_HEAT: DAMPING,
    VISCOUS_HEAT: VISCOUS,
    TRANSFER_HEAT: TRANSFER,
    FRICTION_HEAT: FRICTION,
}
"""Columns of the channels that the kernels of nodes and bodies fill."""
ALWAYS: Mapping[Channel, int] = {channel: FIXED_COLUMNS[channel] for channel in (GRAVITY_WORK, SUPPORT_WORK)}
"""Channels that every history contains, with their columns."""

ONLY_TAKE: Sequence[Channel] = (CONTACT_WORK, TRANSFER_HEAT, FRICTION_HEAT)
"""Channels that can only remove energy from bodies; energy that they add to the bodies in sum is an error of the method."""


def channel_of_load(name: str) -> Channel:
    """Return the channel (entry of the energy balance) of the work of external forces with this name. The sign of the
    channel is 1 (energy added to the system), except for the work of enclosed fluids and of surface tension, which is an
    exchange within the system (0)."""
    passing = {channel.name: channel for channel in (ENCLOSED_WORK, SURFACE_TENSION_WORK)}
    return passing.get(name, Channel(name))


class WorkLayout:
    """Order of the columns in a row of works [J] for the channels (entries of the energy balance) of a run, and the number
    of supports whose impulses are summed.

    loads: channels of external forces, each with a nodal array and a column starting at FIRST_LOAD; others: channels of
    work counted by conditions or kernels. channels: all channels shown in the history, in the order of its columns, with
    their columns in a row of works. touching: True if surfaces are in contact; the last nodal array then contains the
    contact forces, whose work is added to the contact work. Raises ValueError if two channels have the same name.
    """

    def __init__(
        self, loads: Iterable[Channel] = (), others: Iterable[Channel] = (), n_supports: int = 0, touching: bool = False
    ) -> None:
        loads, others = dict.fromkeys(loads), dict.fromkeys(others)
        own = [*loads, *(channel for channel in others if channel not in FIXED_COLUMNS and channel not in loads)]
        names = [channel.name for channel in (*FIXED_COLUMNS, *own)]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"two channels of the energy balance have the name {repeated[0]}")
        self.loads = tuple(loads)
        self.n_loads, self.n_supports = len(loads) + touching, n_supports
        self.n_columns = FIRST_LOAD + touching + len(own)
        self.surface_contact = FIRST_LOAD + len(loads) if touching else None
        """Column of the work of forces between surfaces; None without contact of surfaces."""
        columns = {channel: FIRST_LOAD + number + (touching and number >= len(loads)) for number, channel in enumerate(own)}
        fixed = {channel: column for channel, column in FIXED_COLUMNS.items() if channel in others}
        self.channels: Mapping[Channel, int] = {**ALWAYS, **columns, **fixed}

    def column(self, channel: Channel) -> int:
        """Return the column of a channel (entry of the energy balance) of this run in a row of works. Raises UnknownName if
        no condition or body of the run declares the channel with this name and sign."""
        if channel not in self.channels:
            known = [f"{each.name} (sign {each.sign:g})" for each in self.channels]
            raise UnknownName(absent("the energy balance has no channel", f"{channel.name} (sign {channel.sign:g})", known))
        return self.channels[channel]

    def no_work(self) -> "StepWork":
        """Return a `StepWork` of zeros with all columns and supports of this layout."""
        return no_work(self.n_columns, self.n_supports)


class StepWork(NamedTuple):
    """Work and impulses of a step, summed over bodies and nodes."""

    works: np.ndarray  # (columns,) work by column [J]; last columns may be missing if they are zero
    gravity_mass: float  # mass of the nodes on which gravity acts [kg]
    reactions: np.ndarray  # (supports + 1, 3) impulses of the supports; last row: of axes one cell thick [N s]
    impulse: np.ndarray  # (3,) impulse of all other external actions [N s]
    motions: Mapping[str, np.ndarray]  # impulses of prescribed motions by name, shape (3,) [N s]
    turning: Mapping[str, np.ndarray] = {}  # angular impulses of rigid-body motions about the centres of mass, by name [N m s]


def no_work(columns: int, n_supports: int) -> StepWork:
    """Return a `StepWork` of zeros with this number of columns and supports."""
    return StepWork(np.zeros(columns), 0.0, np.zeros((n_supports + 1, 3)), np.zeros(3), {})


def row_length(columns: int, n_impulses: int) -> int:
    """Return the number of entries of the row that a kernel sums: the columns of work, the mass on which gravity acts, and
    three components of each impulse."""
    return columns + 1 + 3 * n_impulses


def step_work(sums: np.ndarray, columns: int) -> StepWork:
    """Convert a row summed by a kernel, see `row_length`, to the work of a step. columns: number of columns of work.

    The impulses of the supports and of axes that are one cell thick come first in the row; the impulse of loads and absorbing
    faces comes last.
    """
    impulses = sums[columns + 1 :].reshape(-1, 3)
    return StepWork(sums[:columns], float(sums[columns]), impulses[:-1], impulses[-1], {})


def total_work(parts: Sequence[StepWork], columns: int) -> StepWork:
    """Sum the works and impulses of several parts of a step, in their order; the sum has `columns` columns of work."""
    works, gravity_mass = np.zeros(columns), 0.0
    reactions, impulse = np.zeros((max(len(part.reactions) for part in parts), 3)), np.zeros(3)
    motions: dict[str, np.ndarray] = {}
    turning: dict[str, np.ndarray] = {}
    for part in parts:
        works[: len(part.works)] += part.works
        gravity_mass += part.gravity_mass
        reactions += part.reactions
        impulse += part.impulse
        for total, given in ((motions, part.motions), (turning, part.turning)):
            for name, more in given.items():
                total[name] = total[name] + more if name in total else more
    return StepWork(works, gravity_mass, reactions, impulse, motions, turning)


class Passed(NamedTuple):
    """Sums over the points that left a body in a step or entered a body after the step: number, mass, momentum and
    energies."""

    points: int  # number of points
    mass: float  # sum over the points [kg]
    momentum: np.ndarray  # (3,) sum over the points [kg m/s]
    kinetic: float  # kinetic energy [J]
    stored: float  # internal or strain energy [J]
    half_power: float = 0.0  # half the power of the internal forces, as in `Totals` [W]


def kinetic_energies(mass: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the kinetic energies of points with masses [kg], shape (n,), and velocities [m/s], shape (n, 3): shape (n,)
    [J]."""
    return np.asarray(0.5 * mass * np.einsum("ij,ij->i", velocity, velocity))
