"""A sheet that falls on a sphere, and a sphere that falls on a sheet, by explicit finite elements of our own.

    python reference.py membrane-on-sphere        # some 10 minutes each
    python reference.py sphere-on-membrane

writes the table that the package compares runs with, and prints what mesh, step, contact and the sphere's elasticity change.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from explicit import COLUMNS, Choice, run

TABLES = Path(__file__).parents[2] / "src/pellucid/references"
NOISE = 1e-6  # m, a hundredth of the thickness


def main(case: str) -> None:
    times, columns = (drape if case == "membrane-on-sphere" else impact)(case)
    names = f"time,{','.join(columns)}\n# s{',m' * len(columns)}"
    header = f"# {case} by finite elements: validation/lian2014-finite-elements/reference.py.\n{names}"
    path = TABLES / f"{case.replace('-', '_')}.csv"
    np.savetxt(path, np.column_stack([times, *columns.values()]), "%.8g", ",", header=header, comments="")


def impact(case: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The sphere on the sheet: columns of the finest mesh and, "coarse", of the paper's."""
    finest = report("0.25 mm", Choice(case, 2.5e-4))
    coarse = report("1 mm", Choice(case))
    others = {
        "0.5 mm": Choice(case, 5e-4),
        "2 mm": Choice(case, 2e-3),
        "0.5 mm, half the step": Choice(case, 5e-4, courant=0.25),
        "0.5 mm, coarser ball": Choice(case, 5e-4, ball=(8, 4)),
        "0.5 mm, rigid ball": Choice(case, 5e-4, rigid=True),
        "0.5 mm, penalty 0.1": Choice(case, 5e-4, penalty=0.1),
        "0.5 mm, penalty 0.01": Choice(case, 5e-4, penalty=0.01),
        "0.5 mm, tension field": Choice(case, 5e-4, tension_field=True),
        "0.5 mm, 0.9 of the stress at centres": Choice(case, 5e-4, central=0.9),
    }
    compare("1 mm", coarse, finest)
    half = None
    for name, choice in others.items():
        found = report(name, choice)
        compare(name, found, finest if half is None or "," not in name else half)
        half = found if half is None else half
    first, second = COLUMNS[case]
    return finest.times, {
        first: finest.curves[:, 0],
        second: finest.curves[:, 1],
        f"coarse_{first}": coarse.curves[:, 0],
        f"coarse_{second}": coarse.curves[:, 1],
    }


def drape(case: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The sheet on the sphere: means over sheets that differ by noise, their range, and the tension field."""
    first, second = COLUMNS[case]
    times, paper = family("1 mm", Choice(case), 16)
    _, fine = family("0.5 mm", Choice(case, 5e-4), 8)
    relaxed = report("0.5 mm, tension field", Choice(case, 5e-4, tension_field=True))
    for name, choice, count in (
        ("2 mm", Choice(case, 2e-3), 8),
        ("0.25 mm, rigid ball", Choice(case, 2.5e-4, rigid=True), 3),
        ("1 mm, rigid ball", Choice(case, rigid=True), 8),
        ("1 mm, a fifth of the step", Choice(case, rigid=True, courant=0.1), 8),
        ("1 mm, ten times the noise", Choice(case, rigid=True, noise=10 * NOISE), 8),
        ("1 mm, penalty 0.1", Choice(case, rigid=True, penalty=0.1), 8),
        ("1 mm, 0.9 of the stress at centres", Choice(case, rigid=True, central=0.9), 8),
    ):
        _, others = family(name, choice, count)
        apart(name, others, paper)
    apart("0.5 mm", fine, paper)
    report("1 mm, no noise, rigid ball", Choice(case, rigid=True))
    compare("1 mm, tension field", report("1 mm, tension field", Choice(case, tension_field=True)), relaxed)
    compare("0.25 mm, tension field", report("", Choice(case, 2.5e-4, tension_field=True, rigid=True)), relaxed)
    for seed in (1, 2):
        noisy = Choice(case, 5e-4, tension_field=True, noise=NOISE, seed=seed)
        compare(f"0.5 mm, tension field, noise {seed}", report("", noisy), relaxed)
    springs = Choice(case, 5e-4, tension_field=True, penalty=0.1)
    compare("0.5 mm, tension field, impacts rebound", report("0.5 mm, tension field, penalty 0.1", springs), relaxed)
    columns = {first: paper[:, :, 0].mean(0), second: paper[:, :, 1].mean(0)}
    columns |= {f"least_{second}": paper[:, :, 1].min(0), f"greatest_{second}": paper[:, :, 1].max(0)}
    columns |= {f"fine_{first}": fine[:, :, 0].mean(0), f"fine_{second}": fine[:, :, 1].mean(0)}
    columns |= {f"relaxed_{first}": relaxed.curves[:, 0], f"relaxed_{second}": relaxed.curves[:, 1]}
    return times, columns


def report(name: str, choice: Choice):
    """Runs and prints balances and extremes [mm, ms]."""
    found = run(choice)
    if name:
        extremes = []
        for column, curve in zip(COLUMNS[choice.case], 1e3 * found.curves.T, strict=True):
            low = curve.argmin()
            extremes.append(f"{column} lowest {curve[low]:.4f} mm at {1e3 * found.times[low]:.3f} ms, ends at {curve[-1]:.4f}")
        print(
            f"{name}: {found.steps} steps, energy {100 * found.energy:.2g} %, momentum {found.momentum:.1e}, "
            f"contact took {100 * found.absorbed:.2g} %; {'; '.join(extremes)}",
            flush=True,
        )
    return found


def compare(name: str, found, other) -> None:
    """Largest differences over the other's largest excursions."""
    scale = np.abs(other.curves - other.curves[0]).max(0)
    shares = np.abs(found.curves - other.curves).max(0) / scale
    print(f"  {name}: differs by {', '.join(f'{100 * share:.2f} %' for share in shares)}", flush=True)


def family(name: str, choice: Choice, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and curves (count, k, 2) of sheets that differ by noise; prints their scatter at some instants."""
    choice = replace(choice, noise=choice.noise or NOISE)
    found = [run(replace(choice, seed=seed)) for seed in range(1, count + 1)]
    times, curves = found[0].times, np.array([one.curves for one in found])
    print(f"{name}: {count} sheets, energy {100 * max(one.energy for one in found):.2g} %", flush=True)
    for column, values in zip(COLUMNS[choice.case], np.moveaxis(1e3 * curves, 2, 0), strict=True):
        at = [f"{1e3 * times[i]:.2f}: {values[:, i].mean():.2f} ± {values[:, i].std():.2f}" for i in range(0, len(times), 25)]
        print(f"  {column} [ms: mm] {', '.join(at)}", flush=True)
    return times, curves


def apart(name: str, curves: np.ndarray, others: np.ndarray) -> None:
    """Largest differences of the means over the others' largest excursions."""
    mean, other = curves.mean(0), others.mean(0)
    shares = np.abs(mean - other).max(0) / np.abs(other - other[0]).max(0)
    print(f"  {name}: means differ by {', '.join(f'{100 * share:.2f} %' for share in shares)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
