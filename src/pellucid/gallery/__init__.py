"""The gallery: cases that are at once example, test and convergence study. `pellucid.catalogue` lists and reads them."""
