"""Settings of the drag of the fluid around a film in a case file."""

from pellucid.model import Model, parameter


class DragCase(Model):
    """Drag coefficients of the fluid around a film."""

    normal: float = parameter("N*s/m^3", "normal drag coefficient ζ_n", ge=0)
    tangential: float = parameter("N*s/m^3", "tangential drag coefficient ζ_t", ge=0)
