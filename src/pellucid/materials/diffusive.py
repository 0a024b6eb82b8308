"""Material of a field that diffuses, such as a concentration."""

from typing import Literal

from pellucid.materials.contract import BodyMaterial
from pellucid.model import parameter


class DiffusiveMaterial(BodyMaterial):
    """Fick's law: the flux of the concentration c is -D ∇c, with the diffusion coefficient D."""

    kind: Literal["diffusive"] = "diffusive"
    density: float = parameter("kg/m^3", "density of the carrier medium; it affects only the masses in the results", 1.0, gt=0)
    diffusivity: float = parameter("m^2/s", "coefficient of diffusion D", gt=0)

    def wave_speeds(self) -> tuple[float, float]:
        """Return zero for both wave speeds: there are no waves."""
        return 0.0, 0.0
