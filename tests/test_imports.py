"""Modules of the package must not import each other in cycles. The tool lint-imports checks the order of the folders only.

Imports for annotations count between top-level folders, but not within one: there a class may be named by the classes that
it builds.
"""

import ast
from pathlib import Path

import pellucid

PACKAGE = Path(pellucid.__file__).parent


def modules() -> dict[str, Path]:
    found = {}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imported(name: str, path: Path, known: set[str]) -> set[str]:
    """Return the modules of the package that a module imports anywhere in its text, also only for annotations; known: all
    modules."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} has a relative import"
            full = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {item if item in known else str(node.module) for item in full}
    return (found & known) - {name}


def named_in_its_room(name: str, path: Path) -> set[str]:
    """Return the modules of the same top-level folder of the package that a module imports for annotations only."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            found |= {inner.module or "" for inner in node.body if isinstance(inner, ast.ImportFrom)}
    return {module for module in found if module.split(".")[:2] == name.split(".")[:2]}


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return the groups of modules that import each other, directly or indirectly (Tarjan 1972, SIAM J. Comput. 1, 146)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups = []

    def visit(name: str) -> None:
        index[name] = low[name] = len(index)
        stack.append(name)
        for other in sorted(graph[name]):
            if other not in index:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], index[other])
        if low[name] == index[name]:
            group = stack[stack.index(name) :]
            del stack[stack.index(name) :]
            if len(group) > 1:
                groups.append(sorted(group))

    for name in sorted(graph):
        if name not in index:
            visit(name)
    return groups


def test_cycles_are_found() -> None:
    graph = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set(), "e": {"d", "f"}, "f": {"e"}}
    assert cycles(graph) == [["a", "b", "c"], ["e", "f"]]


def test_no_module_leads_back_to_itself() -> None:
    paths = modules()
    graph = {name: imported(name, path, set(paths)) for name, path in paths.items()}
    assert graph["pellucid.results.report.report"] > {"pellucid.results.pictures.films"}, "imports are seen"
    assert "pellucid.parts.assembly" in graph["pellucid.parts.condition"], "so are those that only annotations need"
    for name, path in paths.items():
        graph[name] -= named_in_its_room(name, path)
    assert cycles(graph) == []
