"""Files of a run, and the classes that read them."""
