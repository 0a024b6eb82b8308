"""A case that goes on from the state of an earlier run, as the user describes it."""

from collections.abc import Iterator
from pathlib import Path as FilePath

from pellucid.findings import Finding, Path
from pellucid.model import InputFile, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts


class StartCase(Part):
    """Bodies begin in the state that bodies of the same names had in an earlier run; time, works and impulses begin at zero.

    Places, velocities and what the material carries come from that run; grid, supports, motions and loads are those of the
    case, whose regions choose among the points where they are then.
    """

    path: InputFile = parameter("", "folder of the earlier run; a relative path starts from the case file's folder")
    time: float | None = parameter(
        "s", "instant of that run: the nearest frame of the fields; without it its last checkpoint", None, ge=0
    )
    body: tuple[str, ...] | None = parameter("", "names of the bodies; without it all that both runs have", None)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """No run there, or no such body here."""
        folder = FilePath(self.path)
        if not (folder / "case.toml").is_file():
            other = "it is a file" if folder.exists() else "there is no such folder"
            what = "it has no case.toml" if folder.is_dir() else other
            within = folder.is_file() and (folder.parent / "case.toml").is_file()
            remedy = f'name the folder: path = "{folder.parent}"' if within else "name the --out of a run of pellucid"
            yield Finding((*path, "path"), f"is no folder of a run: {what}", remedy)
        if self.body == ():
            yield Finding((*path, "body"), "names no body", "leave it out for all bodies that both runs have, or drop [start]")
        names = [body.name for body in parts.of(BodyModel)]
        for number, name in enumerate(self.body or ()):
            if name not in names:
                yield Finding((*path, "body", number), f"there is no such body; those of the case are {', '.join(names)}")
