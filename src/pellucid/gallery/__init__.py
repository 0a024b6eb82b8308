"""The gallery: cases that are examples, tests and convergence studies. `pellucid.catalogue` lists and reads them."""

MODULES = {
    "basics/blast-in-space": "basics.blast",
    "basics/sod": "gan2011.shock_tube",
    "benet2015/compressed-sphere": "benet2015.growing",
    "benet2015/compressed-sphere-in-space": "benet2015.growing",
    "benet2015/inflated-vesicle": "benet2015.growing",
    "benet2015/translating-sphere": "benet2015.translating",
    "benet2015/translating-sphere-in-space": "benet2015.translating",
    "benet2015/translating-vesicle": "benet2015.translating",
    "mountris2019/cylinder-indentation": "mountris2019.indentation",
    "mountris2019/heart-indentation": "mountris2019.indentation",
}
"""Modules with the metrics and figures of several cases. Other cases have a module of their own name, or none."""
