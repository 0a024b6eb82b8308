"""Small problems with exact solutions or classical experiments: what the core is checked against."""
