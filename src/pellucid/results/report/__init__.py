"""`report.html`: one file that tells what was run, whether it is right, and what it looks like."""
