"""Error message for loads on a film without drag that no resistance can balance."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.bodies.fluid_film.forms.film_forces import in_space

PLANE = (0, 1)
ROUNDING = 1e-9  # smallest resultant that is reported, relative to the driving forces


def why_unbalanced(driven: np.ndarray, x: np.ndarray, axes: Sequence[int], loads: Mapping[str, np.ndarray]) -> str:
    """Return a text that describes the loads on motions without resistance; it continues a sentence that starts with the name
    of the film.

    driven: forces of the loads on these motions [N], shape (n, d); x: nodal positions [m], shape (n, d); axes: the d axes of
    space of the components; loads: nodal forces of each load by name, shape (n, d) each [N].
    """
    size, whole = _size(driven), _size(sum(loads.values(), np.zeros_like(driven)))
    shares = {label: abs(float(np.sum(force * driven))) for label, force in loads.items()}
    most = max(shares, key=lambda label: shares[label])
    forces, places = in_space(driven, axes), in_space(x - x.mean(axis=0), axes)
    resultant, torque = np.linalg.norm(forces.sum(axis=0)), np.linalg.norm(np.cross(places, forces).sum(axis=0))
    reach = float(np.linalg.norm(places, axis=1).max())
    parts = [f"a resultant of {resultant:.3g} N"] if resultant > ROUNDING * size else []
    parts += [f"a torque of {torque:.3g} N m"] if torque > ROUNDING * size * reach else []
    has = f", with {' and '.join(parts)}" if parts else ""
    plane = tuple(axes) == PLANE
    balance = "its tension must balance the loads on a curve" if plane else "resultant forces and torques cannot be balanced"
    return (
        f"is driven along motions without resistance, mainly by {most}: forces of {size:.3g} N, {100.0 * size / whole:.2g} % "
        f"of the loads{has}; without drag {balance}; add `drag`, or change the loads"
    )


def _size(forces: np.ndarray) -> float:
    """Return the sum of the magnitudes of nodal forces [N], which approximates ∫|b| dA for a load b per unit area."""
    return float(np.linalg.norm(forces, axis=1).sum())
