"""The report of a run, `report.html`: one file with the case, the results of the checks, and pictures."""
