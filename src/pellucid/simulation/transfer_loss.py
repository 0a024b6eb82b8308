"""What the transfers between points and grid lost of the kinetic energy in a step: heat that a body kept, or heat that left."""

from collections.abc import Iterable, Sequence

from pellucid.energy import INTERNAL, TRANSFER, StepWork, no_work
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.families import GridBody


def part_forces(bodies: Iterable[Sequence[GridBody]]) -> None:
    """Let the bodies of each velocity field that keep heat have their forces apart, where others do not keep it."""
    for together in bodies:
        if not all(body.keeps_heat for body in together):
            for body in together:
                if body.keeps_heat:
                    body.keep_forces_apart()


def transfer_work(field: VelocityField, bodies: Sequence[GridBody], dt: float, strained_last: bool) -> StepWork:
    """Of the bodies on the grid of one velocity field over a step dt [s].

    Bodies that keep heat take it with the work of their internal forces. Others are strained along velocities that are mapped
    from the points again (MUSL, USF), and stress works less along these than forces did on the nodes: so what lumping takes of
    free motion comes back in full. What contact, supports and other impulses on nodes lose by lumping does not, nor what is
    lost otherwise: that is heat which leaves. With the momentum equation first the nodes tell which is which; with USF lumping
    counts as if all of it came back.
    """
    others = [body.transfer_loss for body in bodies if not body.keeps_heat]
    kept = [body.transfer_loss for body in bodies if body.keeps_heat]
    lost = sum(loss.total for loss in others)
    returned = sum(loss.lumping for loss in others)
    if strained_last and others:
        returned = field.mapping_work(dt)
    done = no_work(TRANSFER + 1, 0)
    done.works[INTERNAL] = -returned - sum(loss.kept for loss in kept)
    done.works[TRANSFER] = lost - returned + sum(loss.total - loss.kept for loss in kept)
    return done


def return_heat(bodies: Iterable[GridBody], made: float) -> StepWork:
    """Where the transfers of a step made energy [J], let bodies return it from the heat that they kept in this step.

    In a velocity field that a fluid shares with others, the fluid keeps what lumping takes of its points, the others get back
    what it takes of the work of their forces: the two overlap.
    """
    keeping = [body for body in bodies if body.keeps_heat]
    kept = sum(body.transfer_loss.kept for body in keeping)
    done = no_work(TRANSFER + 1, 0)
    if made > 0.0 and kept > 0.0:
        share = min(made / kept, 1.0)
        for body in keeping:
            body.return_heat(share)
        done.works[[INTERNAL, TRANSFER]] = share * kept
    return done
