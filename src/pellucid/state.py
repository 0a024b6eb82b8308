"""Fields of points and nodes that are stored or shown: number of components, unit, meaning. Fields of a single kind of body
or material are declared in the package of that kind."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeVar

from pellucid.errors import UnknownName

Value = TypeVar("Value")
COMPONENT_NAMES: dict[int, tuple[str, ...]] = {
    3: ("x", "y", "z"),
    6: ("xx", "yy", "zz", "yz", "xz", "xy"),
    9: ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}
"""Names of the components by their number, for vectors, symmetric tensors, and tensors row by row, along the axes in space."""
FRAME_NAMES = tuple(f"{row}{axis}" for row in "12n" for axis in "xyz")


class Field(NamedTuple):
    """Description of a field of points or nodes that results store and show: number of components, SI unit and meaning."""

    components: int  # number of components, such as 1, 3 or 6
    unit: str  # SI unit
    meaning: str  # description for the user
    own_names: tuple[str, ...] = ()
    """Names of components that are not along the axes in space."""
    shown: bool = True
    """False if results do not show the array; checkpoints contain it."""
    leaves: bool = False
    """True if the value of a point becomes zero when the point leaves through a face of the grid."""
    begins: bool = False
    """True if the array starts at zero when a run continues from results that lack it."""
    part_of: str = ""
    """Name of a field to which results add this array. That field is then computed from other arrays when a run continues
    from results."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the components of the field; empty for a scalar and for unnamed components."""
        return self.own_names or COMPONENT_NAMES.get(self.components, ())


class Fields(dict[str, Field]):
    """Fields by name. Raises `UnknownName` with a remedy for an array that is not declared."""

    def __missing__(self, name: str) -> Field:
        raise UnknownName(
            f"the array `{name}` of points is not declared\n    Declare its `Field` (unit, meaning) under this name in "
            "`point_fields` of the class of the step part that adds the array, or in `fields` of the model of the body."
        )


FIELDS = Fields(
    {
        "id": Field(1, "1", "number of the point, in the order of seeding"),
        "position": Field(3, "m", "position"),
        "velocity": Field(3, "m/s", "velocity", leaves=True),
        "mass": Field(1, "kg", "mass", leaves=True),
        "volume": Field(1, "m^3", "current volume", shown=False, leaves=True),
        "density": Field(1, "kg/m^3", "density: mass divided by current volume"),
        "pressure": Field(1, "Pa", "pressure of the equation of state; for solids, minus the mean stress"),
        "stress": Field(6, "Pa", "Cauchy stress, components xx, yy, zz, yz, xz, xy", leaves=True),
        "internal_energy": Field(1, "J/kg", "specific internal energy"),
        "strain_energy": Field(1, "J/kg", "specific strain energy; for rate-form solids and membranes, the work of the stress"),
        "kinetic_energy": Field(1, "J", "kinetic energy of the point; the sum is the kinetic energy of the body"),
        "stored_energy": Field(1, "J", "internal or strain energy of the point; the sum is the stored energy of the body"),
        "driven": Field(1, "1", "number (from 1) of the prescribed motion of the point; 0 if the point is free", shown=False),
        "start": Field(3, "m", "initial position; only for bodies with a prescribed motion", shown=False),
        "angle": Field(
            3, "rad", "rotation of a rigid body about x, y and z since the start, including full turns", shown=False
        ),
        "frame": Field(
            9,
            "1",
            "tangent frame of a membrane: rows first tangent, second tangent, normal",
            FRAME_NAMES,
        ),
        "in_plane": Field(
            4, "1", "in-plane strain or deformation gradient of a membrane in its frame", ("11", "12", "21", "22")
        ),
        "plane_stress": Field(3, "Pa", "Cauchy stress of a membrane in its frame, components 11, 22, 12", ("11", "22", "12")),
        "thickness": Field(1, "m", "current thickness of a membrane of elements at the node: mean over the adjacent elements"),
        "prescribed": Field(3, "1", "for each direction 0 if the node is free, else 1 + index of the prescribed motion"),
        "damage": Field(1, "1", "damage of a membrane: largest excess of strain over the elastic limit, divided by the limit"),
        "failed": Field(1, "1", "1 if the membrane point has failed and carries no stress, else 0"),
        "torn": Field(
            3,
            "1",
            "strain that opened a failed point of a membrane since it failed, in its frame, components 11, 22, 12",
            ("11", "22", "12"),
            shown=False,
        ),
        "dissipated_energy": Field(1, "J/kg", "part of the work of the stress dissipated by damage or viscosity"),
        "deformation_gradient": Field(9, "1", "deformation gradient, row by row"),
        "affine": Field(9, "1/s", "affine velocity field about the point, for APIC", shown=False, leaves=True, begins=True),
    }
)


def declare_field(name: str, field: Field, owner: str) -> None:
    """Declare an additional field of a kind of body or material. Raises TypeError, with the owner, if another field has
    this name."""
    if FIELDS.setdefault(name, field) != field:
        raise TypeError(f"{owner}.{name}: a field of this name exists ({FIELDS[name].meaning}); choose another name")


def parts_of(name: str, arrays: Iterable[str]) -> list[str]:
    """Return those of the arrays, by name, that results add to the field with this name."""
    return [part for part in arrays if part in FIELDS and FIELDS[part].part_of == name]


def with_owner(owner: str, values: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values, such as state arrays, under new names for checkpoints; each new name begins with the name of the
    owner (a body, the clock)."""
    return {f"{owner}/{name}": value for name, value in values.items()}


def of_owner(owner: str, values: Mapping[str, Value]) -> dict[str, Value]:
    """Return those values, such as state arrays, whose names begin with the name of an owner (a body, the clock), under
    their names without this beginning; inverse of `with_owner`."""
    return {name.removeprefix(f"{owner}/"): value for name, value in values.items() if name.startswith(f"{owner}/")}
