"""Output of a run: files, pictures, report and view, and the classes that read them."""
