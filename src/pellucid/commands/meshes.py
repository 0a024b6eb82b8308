"""The command on files of meshes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pellucid.commands.arguments import print_table
from pellucid.errors import UsageError

if TYPE_CHECKING:
    from pellucid.geometry.mesh_survey import Survey


def mesh(
    file: Annotated[str, typer.Argument(metavar="FILE", help="STL, OBJ, PLY, OFF, Gmsh, VTK, Abaqus, Nastran or other file.")],
    repair: Annotated[bool, typer.Option("--repair", help="Repair the mesh where possible and list the repairs.")] = False,
    close_holes: Annotated[
        int, typer.Option("--close-holes", metavar="N", min=0, max=200, help="With --repair: close holes of up to N edges.")
    ] = 0,
    unit: Annotated[
        str | None, typer.Option("--unit", metavar="UNIT", help="Unit of length of the file, such as mm (default: m).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="NEW", help="Write the mesh, in the unit of FILE, to another file.")
    ] = None,
    picture: Annotated[Path | None, typer.Option("--picture", metavar="FILE.png", help="Draw the mesh into this file.")] = None,
) -> None:
    """Describe the mesh in a file and check that a case can use it; repair, write or draw it. Exit status 2 if it has
    faults."""
    from pellucid.findings import Refusal
    from pellucid.geometry.mesh_survey import survey
    from pellucid.units import UnitError, to_si

    if close_holes and not repair:
        raise UsageError("--close-holes has an effect only with --repair.\n    Add --repair.")
    try:
        metres = 1.0 if unit is None else to_si(f"1 {unit}", "m")
    except UnitError as error:
        raise UsageError(f"--unit {unit}: {error}") from None
    for written in (out, picture):
        if written is not None:
            _check_place(written, file)
    if picture is not None and picture.suffix.lower() != ".png":
        raise UsageError(f"--picture {picture}: only PNG files can be written.\n    Choose a name that ends in .png.")
    try:
        found = survey(file, repair, close_holes, metres)
        print_table(("what", file), found.rows)
        _tell(found, repair)
        if out is not None:
            _write(found, out)
            typer.echo(f"written: {out}")
    except Refusal as error:
        raise UsageError(f"{error.reason.text}\n    {error.reason.remedy}") from None
    if picture is not None:
        _draw(found, metres, picture, Path(file).name)
        typer.echo(f"written: {picture}")
    if found.faults:
        raise typer.Exit(2)


def _check_place(path: Path, file: str) -> None:
    """Raise UsageError if a path cannot be written or is the mesh file itself. file: the mesh file."""
    if path.exists() and Path(file).exists() and path.samefile(file):
        raise UsageError(f"{path} is the input file, which is never overwritten.\n    Choose another name.")
    if path.is_dir() or not path.absolute().parent.is_dir():
        reason = "it is a folder" if path.is_dir() else f"the folder {path.absolute().parent} does not exist"
        raise UsageError(f"{path} cannot be written: {reason}.\n    Choose a file name in an existing folder.")


def _tell(found: "Survey", repair: bool) -> None:
    for note in found.notes:
        typer.echo(f"note: {note}")
    for text, remedy in found.faults:
        typer.echo(f"fault: {text}\n    {remedy}")
    if found.faults:
        return
    typer.echo("no faults" + (" remain" if repair and found.notes else ""))


def _write(found: "Survey", out: Path) -> None:
    from pellucid.geometry.files.writing import check_ending, write_solid, write_surface
    from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
    from pellucid.results.storage.files import replacing

    mesh, ending = found.mesh, out.suffix.lower()
    check_ending(out.name, isinstance(mesh, SimplexMesh))
    with replacing(out) as draft:
        if isinstance(mesh, SimplexMesh):
            write_solid(draft, ending, mesh.nodes, mesh.cells, mesh.sets)
        else:
            write_surface(draft, ending, *mesh)


def _draw(found: "Survey", metres: float, picture: Path, name: str) -> None:
    from pellucid.results.pictures.mesh_picture import mesh_picture
    from pellucid.results.storage.files import replacing

    figure = mesh_picture(found.mesh, metres, name if metres != 1.0 else f"{name}, in units of the file")
    with replacing(picture) as draft:
        figure.savefig(draft, format="png")


COMMANDS = (mesh,)
