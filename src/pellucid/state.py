"""The arrays of points and nodes, declared once: components, unit, meaning."""

from typing import NamedTuple


class Field(NamedTuple):
    """`components` numbers per point, in SI `unit`."""

    components: int
    unit: str
    meaning: str


FIELDS: dict[str, Field] = {
    "id": Field(1, "1", "number of the point, in the order of seeding"),
    "position": Field(3, "m", "position"),
    "velocity": Field(3, "m/s", "velocity"),
    "mass": Field(1, "kg", "mass"),
    "volume": Field(1, "m^3", "current volume"),
    "density": Field(1, "kg/m^3", "density, mass by current volume"),
    "pressure": Field(1, "Pa", "pressure of the equation of state; of solids, minus the mean stress"),
    "stress": Field(6, "Pa", "Cauchy stress, components xx, yy, zz, yz, xz, xy"),
    "internal_energy": Field(1, "J/kg", "specific internal energy"),
    "strain_energy": Field(1, "J/kg", "work of the stress on unit mass, of solids in rate form"),
    "deformation_gradient": Field(9, "1", "deformation gradient, row by row"),
    "affine": Field(9, "1/s", "affine velocity field about the point, for APIC"),
}
