"""The interactive view as part of an HTML page: data, style and program, without network access."""

import base64
import json
import zlib
from html import escape
from importlib.resources import files

import numpy as np

from pellucid.results.pictures.style import DIVERGING, SEQUENTIAL
from pellucid.results.storage.run import Run
from pellucid.results.view.scene import scene_of

BUDGET = 12_000_000
"""Largest size of a page with a view [bytes]."""
LEAST = 1_500_000
"""Smallest size that the view may have, even if the rest of the page leaves less [bytes]."""
SPARE = 300_000
"""Bytes reserved for the texts and tables of the page, including the case."""
COLOURS = 256

PART = """<div class="pellucid-view"><p class="without">{without}</p>
<script type="application/json">{told}</script>
<script type="application/octet-stream">{packed}</script></div>
<style>
{style}</style>
<script>
{banner}
(async () => {{
  const packed = Uint8Array.from(atob("{program}"), (letter) => letter.charCodeAt(0));
  const whole = new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")));
  document.head.append(Object.assign(document.createElement("script"), {{ textContent: await whole.text() }}));
}})();
</script>
"""
WITHOUT = "The interactive view requires WebGL 2 and JavaScript; enable them or use another browser."


def view_of(run: Run, taken: int = 0, without: str = "") -> str:
    """Return the interactive view of a run as self-contained HTML; empty for a run in one dimension.

    taken: size of the rest of the page [bytes], by which the size limit of the view is reduced. without: text that is added
    to the message for browsers without WebGL.
    """
    program = (files(__package__) / "view.js").read_text(encoding="utf-8")
    style = (files(__package__) / "view.css").read_text(encoding="utf-8")
    banner, packed_program = program.splitlines()[0], _letters(zlib.compress(program.encode(), 9))
    room = max(LEAST, BUDGET - taken - len(packed_program) - len(style) - SPARE)
    scene = scene_of(run, int(room * 0.75))  # of four letters each has six bits
    if scene is None:
        return ""
    told = scene.told | {"palettes": {name: _palette(name) for name in (SEQUENTIAL, DIVERGING)}}
    return PART.format(
        without=escape(f"{WITHOUT} {without}"),
        told=json.dumps(told, allow_nan=False).replace("<", "\\u003c"),
        packed=_letters(scene.packed),
        style=style,
        banner=banner,
        program=packed_program,
    )


def _palette(name: str) -> str:
    """Encode the colours of a palette in base64, three bytes each."""
    import matplotlib

    colours = matplotlib.colormaps[name](np.linspace(0.0, 1.0, COLOURS))[:, :3]
    return _letters(np.rint(255.0 * colours).astype(np.uint8).tobytes())


def _letters(data: bytes) -> str:
    """Return bytes as base64 text."""
    return base64.b64encode(data).decode("ascii")
