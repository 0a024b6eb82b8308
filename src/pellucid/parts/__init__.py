"""The parts of a case: the interfaces of bodies and conditions, as models and in a run, and a view of all of them."""
