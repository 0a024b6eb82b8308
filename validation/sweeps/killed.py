"""A sweep killed at random moments and given again, until it is whole: python killed.py DIR [SEED].

No member that was done may be written to again, and the results must be those of members that were left alone.
"""

import random
import signal
import subprocess
import sys
from pathlib import Path

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
SWEEP = ["gan2011/piezo-icsi", "--quick", "--until", "6e-6", "--set", "output.checkpoint=1"]
MODULI = ",".join(f"{modulus}kPa" for modulus in range(10, 34, 2))
LONGEST = 40.0  # s until a kill
RESULTS = ("history.csv", "fields/zona.vtkhdf", "fields/cytoplasm.vtkhdf")


def done(folder: Path) -> dict[str, int]:
    """When each member that is done was last written to."""
    files = folder.glob("members/*/summary.json")
    return {file.parent.name: max(path.stat().st_mtime_ns for path in file.parent.rglob("*")) for file in files}


def require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise SystemExit(otherwise)


def main() -> None:
    out, seed = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    random.seed(seed)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell that begins this in the background ignores it
    command = [sys.executable, "-m", "pellucid", "sweep", *SWEEP, "--over", f"body.zona.material.young_modulus={MODULI}"]
    kills = 0
    while True:
        before = done(out / "killed")
        process = subprocess.Popen(
            [*command, "--out", str(out / "killed")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            status = process.wait(timeout=random.uniform(5.0, LONGEST))
        except subprocess.TimeoutExpired:
            chosen = random.choice(SIGNALS)
            process.send_signal(chosen)
            status, kills = process.wait(), kills + 1
            print(f"{chosen.name}: status {status}, {len(before)} members were done before", flush=True)
        after = done(out / "killed")
        require(all(after[name] == at for name, at in before.items()), "a member that was done was written to")
        if status == 0:
            break
    subprocess.run([*command, "--out", str(out / "whole")], check=True, stdout=subprocess.DEVNULL)
    members = sorted(done(out / "whole"))
    require(members == sorted(done(out / "killed")), "other members")
    for name in members:
        for file in RESULTS:
            one, other = (out / each / "members" / name / file for each in ("killed", "whole"))
            require(one.read_bytes() == other.read_bytes(), f"{name}: {file} differs")
    print(f"{kills} kills, {len(members)} members: none repeated, the same bits as of a sweep that was left alone")


if __name__ == "__main__":
    main()
