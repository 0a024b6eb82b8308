"""The interactive view: reduced data of a run and the part of an HTML page that shows them."""
