"""Open faces of the grid: faces through which points enter (inflow), and faces where points leave, with a prescribed flow or
against a pressure (outflow)."""
