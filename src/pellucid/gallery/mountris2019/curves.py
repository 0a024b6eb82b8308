"""What the cases of Mountris et al. 2019 share: the residual of prescribed displacements, and history against the load."""

from typing import TYPE_CHECKING, Literal

from pellucid.results.metrics import Metric

if TYPE_CHECKING:
    from pellucid.results.storage.run import Run


def form_of(run: "Run") -> Literal["coupled", "decoupled"]:
    """Which neo-Hookean energy the tissue of a run has. Raises ValueError for another law: it has no reference here."""
    kind = run.stored.bodies[0].material
    if kind not in ("neo-hookean", "decoupled-neo-hookean"):
        raise ValueError(f'the references are those of neo-Hookean tissue, not of kind "{kind}"')
    return "coupled" if kind == "neo-hookean" else "decoupled"


def elasticity(run: "Run") -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson's ratio of the first body."""
    material = run.case.body[0].material.model_dump()
    return material["young_modulus"], material["poisson_ratio"]


def residuals(run: "Run", tolerance: float = 1e-12) -> dict[str, Metric]:
    """How far the field is from what is prescribed [m], at the nodes and between them; the paper's is 1e-17 at the nodes."""
    found = {}
    for place, where in (("nodes", "at the nodes of prescribed faces"), ("between", "at places between these nodes")):
        value = float(run.summary[f"ebc_residual_{place}"])
        found[f"ebc_residual_{place}"] = Metric(value, 0.0, value, tolerance, "m", f"of the field {where}")
    return found
