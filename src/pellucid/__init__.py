"""pellucid: membranes, fluids and soft tissue with particles and meshless approximants."""
