"""Run one measurement of the benchmark as a separate process, so that the peak memory of this process is that of the
measurement. Command-line arguments: name of a module of the benchmark, and the arguments of its `measure` as JSON."""

import json
import sys
from importlib import import_module

if __name__ == "__main__":
    found = import_module(f"pellucid.bench.{sys.argv[1]}").measure(**json.loads(sys.argv[2]))
    sys.stdout.write(json.dumps(found) + "\n")
