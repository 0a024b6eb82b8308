"""Piezo-ICSI: where the zona fails, whether the cytoplasm stays inside before it does, and whether the books close."""

from typing import TYPE_CHECKING

from pellucid.gallery.gan2011.piezo_pictures import films, oocyte_cut, oocyte_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

__all__ = ["CAPTIONS", "figures", "films", "metrics"]


def figures(run: "Run") -> dict[str, "Figure"]:
    """Pictures of the oocyte, the course of failure, and where it happened."""
    return {"oocyte_whole": oocyte_whole(run), "oocyte_cut": oocyte_cut(run)}
