"""Twelve members run by hand, six after another in each of two shells, and by a sweep: python beside_hand.py DIR [ROUNDS]."""

import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

CASE = ["gan2011/piezo-icsi", "--quick", "--until", "6e-6"]
KEY = "body.zona.material.young_modulus"
MODULI = [f"{modulus}kPa" for modulus in range(10, 34, 2)]


def pellucid(*arguments: str) -> None:
    subprocess.run(
        [sys.executable, "-m", "pellucid", *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def by_hand(out: Path) -> None:
    def shell(moduli: list[str]) -> None:
        for modulus in moduli:
            pellucid("run", *CASE, "--set", f"{KEY}={modulus}", "--threads", "1", "--no-report", "--out", str(out / modulus))

    shells = [Thread(target=shell, args=(MODULI[first::2],)) for first in (0, 1)]
    for each in shells:
        each.start()
    for each in shells:
        each.join()


def by_sweep(out: Path) -> None:
    pellucid("sweep", *CASE, "--over", f"{KEY}={','.join(MODULI)}", "--workers", "2", "--out", str(out))


def seconds(work, out: Path) -> float:
    begun = time.monotonic()
    work(out)
    return time.monotonic() - begun


if __name__ == "__main__":
    folder, rounds = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    pellucid("run", *CASE, "--threads", "1", "--no-report", "--out", str(folder / "warm"))
    for number in range(rounds):
        hand, sweep = seconds(by_hand, folder / f"hand-{number}"), seconds(by_sweep, folder / f"sweep-{number}")
        print(f"by hand {hand:.1f} s, by sweep {sweep:.1f} s, ratio {sweep / hand:.3f}", flush=True)
