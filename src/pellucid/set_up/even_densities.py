"""Settings that keep the densities of the points of liquids even, for hints, warnings and messages of stopped runs."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from pellucid.errors import CaseError, shown
from pellucid.materials.contract import PointMaterial

if TYPE_CHECKING:
    from pellucid.case import Case


def settings_for_even_densities(case: "Case", names: Collection[str], also: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the settings, by key, that keep the densities of single points even. Settings that the case already has or does
    not accept are left out.

    names: bodies; those that are no liquids are left out, and those in a velocity field with a membrane: `even_points` would
    move points through it, and `cell_pressure` spread the jump of the pressure. also: settings that go with them, by key.
    """
    found: dict[str, Any] = {}
    base = case.with_settings(also) if also else case
    for body in base.body:
        material = getattr(body, "material", None)
        beside_membrane = any(other.is_surface and other.field == body.field for other in base.body)
        if body.name not in names or beside_membrane or not isinstance(material, PointMaterial) or not material.is_liquid:
            continue
        cells, even = f"body.{body.name}.cell_pressure", f"body.{body.name}.material.even_points"
        is_open = bool(case.inflow or case.outflow)  # cell pressures treat faces as walls
        stress = body.implicit_stress
        may_fill = stress is not None and stress.stiffness > 0.0 and not (is_open or getattr(body, "cell_pressure", True))
        if may_fill and accepts(base, found | {cells: True}):
            found[cells] = True
        if not material.keeps_points_even:
            tried = ({even: True}, {"time.transfer": "apic", even: True})
            found |= next((more for more in tried if accepts(base, found | more)), {})
    return found


def accepts(case: "Case", settings: Mapping[str, Any]) -> bool:
    """Return True if the case is valid with these settings, by key."""
    try:
        case.with_settings(settings)
    except CaseError:
        return False
    return True


def advice_on_even_densities(case: "Case", names: Collection[str]) -> str:
    """Return the settings of `settings_for_even_densities` as text; an empty text if there are none."""
    return in_words(settings_for_even_densities(case, names))


def in_words(settings: Mapping[str, Any]) -> str:
    """Return settings by key as text, such as `time.transfer = "apic" and body.water.cell_pressure = true`."""
    return " and ".join(f"{key} = {shown(value)}" for key, value in settings.items())
