"""Key of the kernels of a case. Two cases with the same key need the same kernels, so these are compiled only once."""

import hashlib
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pellucid.case import Case


def kernel_key(case: "Case") -> str:
    """Return a hash of those options of a case (texts and booleans, not numbers and names) that determine which kernels a
    run of the case needs."""
    data = case.to_data()
    bodies = sorted({json.dumps(_choices({**body, "name": "", "field": ""}), sort_keys=True) for body in data["body"]})
    shared = sorted(sum(other["field"] == body["field"] for other in data["body"]) > 1 for body in data["body"])
    conditions = sorted(name for name, tables in data.items() if isinstance(tables, list) and tables)
    functions = case.grid.functions if case.grid_or_none else ""
    several = len({body["field"] for body in data["body"]}) > 1
    what = functions, case.thin, case.time.scheme, case.time.transfer, bodies, shared, several
    return hashlib.sha256(json.dumps((what, conditions)).encode()).hexdigest()[:16]


def _choices(value: Any) -> Any:
    """Return a copy of a part of a case with its texts and booleans; numbers are replaced by the names of their types."""
    if isinstance(value, dict):
        return {key: _choices(item) for key, item in value.items() if key not in ("shape", "surface")}
    return value if isinstance(value, (str, bool)) else type(value).__name__
