"""What the operating system gives: processes, signals, files, and threads of numerical libraries."""
