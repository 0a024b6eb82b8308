"""Energy balance of contact between surfaces: energy stored in springs, dissipated by dampers and friction, or lost.

The work of a contact force in a step uses the mean of the velocities before and after the step, (v_k + v_(k+1))/2. The springs
change with the velocity v_k of the step itself. The difference is the pending energy Δt/2 F·v (as in
`pellucid.energy.budget`). The sum work + taken + stored + Δt/2 F·v is therefore constant if the forces follow from the overlap
and its rate. A change of this sum is the unexplained energy: a point moves past points of the other surface, areas change, or
the step is too long for the vibrations.

The velocities are those of the surfaces. On the grid, drags and transfers of momentum change the velocities of the nodes in
addition; `pellucid.contact.surface_pairs` counts the work of contact forces along these changes as work of the drags and
transfers. With USF, surfaces move with the velocities at the start of a step, and this work remains unexplained.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

UNEXPLAINED = 0.05
"""Limit of the unexplained contact energy, relative to the exchanged energy: energy added or removed by surfaces in contact
beyond the energy of springs and friction. In the impact of a rigid body, contact starts within a step. With ω Δt = 0.3 for
its oscillation on the springs, the account then has an error of (ω Δt)²/4 = 0.0225 of the impact energy; the limit is about
twice this value."""


class Held(NamedTuple):
    """Energies of one contact at the start of a step [J]. `ContactEnergy.begin_step` adds up the energies of all contacts."""

    stored: float = 0.0  # energy in the springs of the overlap
    taken: float = 0.0  # energy dissipated by dampers and friction since the start of the last step
    pending: float = 0.0  # pending energy Δt/2 F·v of all forces


class ContactEnergy:
    """Energy of all contact between surfaces since the run began [J].

    Attributes
    ----------
    work : float
        Work on the bodies.
    taken : float
        Energy dissipated by dampers and friction, including the energy in the springs of friction.
    held : float
        Stored and pending energy at the start of the last step.
    unexplained : float
        Energy that the bodies gained without a source in contact, up to the start of the last step.
    """

    def __init__(self) -> None:
        self.work = self.taken = self.held = self.unexplained = 0.0
        self._at_first: float | None = None

    def begin_step(self, touching: Iterable[Held]) -> None:
        """Add up the stored, dissipated and pending energy of all contacts at the start of a step, and update the
        unexplained energy.

        touching: the energies of each contact.
        """
        self.held = 0.0
        for stored, taken, pending in touching:
            self.held += stored + pending
            self.taken += taken
        if self._at_first is None:
            self._at_first = self.held
        self.unexplained = self.work + self.taken + self.held - self._at_first

    def add_work(self, work: float) -> None:
        """Add the work of contact forces on the bodies in a step, `work` [J], which excludes the work of moving walls."""
        self.work += work

    def warning(self, energy_scale: float) -> str | None:
        """Return a warning if the unexplained energy is large compared with the energy that the bodies have exchanged so far,
        `energy_scale` [J]; None otherwise."""
        amount = self.unexplained
        if abs(amount) <= UNEXPLAINED * energy_scale:
            return None
        gave, effect = ("added", "bodies rebound too fast") if amount > 0.0 else ("removed", "bodies are slowed down")
        return (
            f"contact between surfaces {gave} {abs(amount):.3g} J ({100 * abs(amount) / energy_scale:.2g} % of the exchanged "
            f"energy) in addition to the energy of its springs, dampers and friction, so {effect}. Set a smaller "
            "time.step, or, for deformable bodies, a smaller time.courant, or use finer surfaces and cells."
        )

    def state_numbers(self) -> dict[str, float | None]:
        """Return the energies of contact [J] by name, for a checkpoint."""
        return dict(vars(self))

    def restore(self, numbers: Mapping[str, float | None]) -> None:
        """Restore the energies, the result of `state_numbers`, from a checkpoint."""
        vars(self).update(numbers)
