"""Contents of membranes: enclosed volume, gas or liquid given by mass, and prescribed volumes."""
