"""The report of a run of films by themselves, without a grid."""

from html import unescape

from films import case

import pellucid


def test_only_what_applies_is_told(tmp_path):
    """Films have no grid, no inertia, steps of their own and a density in their surface."""
    run = pellucid.run(case(end=0.1), out=tmp_path / "run")
    page = unescape((run.out / "report.html").read_text())
    told = page.split("<details>")[0]
    assert "density 1 kg/m²" in told
    assert "adaptive steps of the films within steps of the output, to 0.1 s" in told
    assert "flux between the nodes" in told
    for word in ("kg/m³", "MUSL", "FLIP", "Courant", "constant mass of each point", "momentum", "point-steps"):
        assert word not in told
