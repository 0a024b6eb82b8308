"""`pellucid bench`: point-steps per second on this machine, compared with its memory bandwidth and with other programs."""

from pellucid.bench.tables import table as table
from pellucid.bench.whole import bench as bench
