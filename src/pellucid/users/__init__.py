"""Users' own code: loading, and messages for its exceptions."""
