"""Open faces of the grid: faces through which points enter, and faces where points leave by a prescribed flow or against a
pressure."""
