"""Services of the operating system: processes, signals, files, and threads of numerical libraries."""
