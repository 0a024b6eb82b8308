"""Small verification problems with exact solutions or classical experiments."""
