"""The gallery: cases that are examples, tests and convergence studies. `pellucid.catalogue` lists and reads them."""
