"""The view that turns: what a run left, made small enough for a page, and the page's part that shows it."""
