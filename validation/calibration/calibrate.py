"""Recover parameters from curves with noise: python calibrate.py indentation|zona [--out DIR]; writes <name>.csv.

For each of three seeds noise of a stated deviation is added to the curves of a run with known parameters, and `pellucid.fit`
finds these again, from the middle of their ranges on.
"""

import argparse
import csv
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import pellucid
from pellucid.progress import Progress

HERE = Path(__file__).parent
SEEDS = (1, 2, 3)


class Calibration(NamedTuple):
    """What is measured, and what is to be found again."""

    truth: dict[str, float]
    free: dict[str, tuple[float, float]]
    deviations: dict[str, float]
    """Of each probe, as a share of its largest value."""
    finer: dict[str, Any]
    """Settings of the run that is measured, beside those of the fit."""
    until: float


MATERIAL = "body.cylinder.material"
ZONA = "body.zona.material"
CALIBRATIONS = {
    "indentation": Calibration(
        {f"{MATERIAL}.young_modulus": 3000.0, f"{MATERIAL}.poisson_ratio": 0.4},
        {f"{MATERIAL}.young_modulus": (1e3, 2e4), f"{MATERIAL}.poisson_ratio": (0.2, 0.48)},
        {"force": 0.03, "bulge": 0.03},
        {"steady.tolerance": 1e-4},
        1.0,
    ),
    "zona": Calibration(
        {f"{ZONA}.young_modulus": 17900.0, f"{ZONA}.damage.elastic_limit": 0.06},
        {f"{ZONA}.young_modulus": (1e3, 1e5), f"{ZONA}.damage.elastic_limit": (0.03, 0.14)},
        {"force": 0.08},
        {"body.zona.surface.disc.rings": 30, "time.courant": 0.2},
        3e-4,
    ),
}


def measured(run: pellucid.Run, chosen: Calibration, seed: int, folder: Path) -> dict[str, Path]:
    """Files of the probes of a run with noise, without the row at the start."""
    noise, files = np.random.default_rng(seed), {}
    folder.mkdir(parents=True, exist_ok=True)
    for probe, share in chosen.deviations.items():
        t, values = run.history["time"][1:], run.history[probe][1:]
        known = t <= chosen.until * (1.0 + 1e-9)
        deviation = share * float(np.abs(values).max())
        files[probe] = folder / f"{probe}.csv"
        with files[probe].open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            unit = run.units[probe]
            writer.writerows([("time", probe, "deviation"), ("s", unit, unit)])
            noisy = values[known] + noise.normal(0.0, deviation, int(known.sum()))
            writer.writerows((repr(float(a)), repr(float(b)), deviation) for a, b in zip(t[known], noisy, strict=True))
    return files


def calibrate(
    name: str, out: Path, seeds: tuple[int, ...] = SEEDS, settings: dict[str, Any] | None = None
) -> list[dict[str, Any]]:
    """A row for each seed and parameter: the truth, the estimate, its 95 % interval, the seconds that the fit took."""
    chosen = CALIBRATIONS[name]
    case = pellucid.load(HERE / f"{name}.toml").with_settings(settings or {})
    run = pellucid.run(case.with_settings(chosen.truth | chosen.finer), out / "measured", report=False)
    rows = []
    for seed in seeds:
        begun = time.monotonic()
        files = measured(run, chosen, seed, out / f"curves-{seed}")
        found = pellucid.fit(case, files, chosen.free, out=out / f"fit-{seed}", progress=Progress())
        seconds = time.monotonic() - begun
        for key, one in found.estimates.items():
            within = one.low <= chosen.truth[key] <= one.high
            row = {"seed": seed, "parameter": key, "truth": chosen.truth[key], **one._asdict(), "within": within}
            rows.append(row | {"chi_square": found.chi_square, "runs": len(found.members), "seconds": round(seconds, 1)})
            print({key: f"{value:.5g}" if isinstance(value, float) else value for key, value in rows[-1].items()}, flush=True)
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("name", choices=CALIBRATIONS)
    parser.add_argument("--out", type=Path, default=Path("fits"))
    arguments = parser.parse_args()
    table = calibrate(arguments.name, arguments.out / arguments.name)
    with (HERE / f"{arguments.name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, table[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(
            {key: f"{value:.5g}" if isinstance(value, float) else value for key, value in row.items()} for row in table
        )
