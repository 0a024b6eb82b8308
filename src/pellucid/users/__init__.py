"""Users' own code: how it is found and loaded, and how its exceptions are told."""
