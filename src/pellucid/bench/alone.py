"""A measurement in a separate process with its own peak memory; arguments: a module of the benchmark and its arguments as
JSON."""

import json
import sys
from importlib import import_module

if __name__ == "__main__":
    found = import_module(f"pellucid.bench.{sys.argv[1]}").measure(**json.loads(sys.argv[2]))
    sys.stdout.write(json.dumps(found) + "\n")
