"""`pellucid bench`: particle-steps a second on this machine, beside its memory bandwidth and other programs."""

from pellucid.bench.tables import table as table
from pellucid.bench.whole import bench as bench
