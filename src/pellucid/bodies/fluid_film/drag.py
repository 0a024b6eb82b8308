"""The drag of the fluid about a film as the user describes it."""

from pellucid.model import Model, parameter


class DragCase(Model):
    """Drag coefficients of the fluid around a film."""

    normal: float = parameter("N*s/m^3", "ζ_n, against its velocity along the normal", ge=0)
    tangential: float = parameter("N*s/m^3", "ζ_t, against its velocity in the surface", ge=0)
