"""Tension curves of cells/tension-curves, from the energies alone: no formula for a tension is used.

    python validation/cells-tension-curves/exact.py > src/pellucid/gallery/cells/tension-curves-exact.csv

The energy W(λ₁, λ₂) of unit initial area is differentiated numerically with 50 digits; a strip has the width at which
∂W/∂λ₂ = 0, found by search. T = (1/λ₂) ∂W/∂λ₁, over G, for Arruda and Boyce's law over μ. Needs mpmath.
"""

from mpmath import diff, findroot, mp, mpf

mp.dps = 50


def neo_hookean(a, b):
    return (a**2 + b**2 + 1 / (a * b) ** 2 - 3) / 2


def skalak(a, b):
    I1, I2 = a**2 + b**2 - 2, (a * b) ** 2 - 1
    return (I1**2 + 2 * I1 - 2 * I2 + I2**2) / 4


def evans_skalak(a, b):
    return 5 * (a * b - 1) ** 2 + (a**2 + b**2) / (2 * a * b) - 1


def arruda_boyce(a, b):
    I, n = a**2 + b**2 + 1 / (a * b) ** 2, 8
    c = (mpf(1) / 2, mpf(1) / 20, mpf(11) / 1050, mpf(19) / 7000, mpf(519) / 673750)
    return sum(c[k - 1] * (I**k - mpf(3) ** k) / mpf(n) ** (k - 1) for k in range(1, 6))


LAWS = {"neo-hookean": neo_hookean, "skalak": skalak, "evans-skalak": evans_skalak, "arruda-boyce": arruda_boyce}


def natural_width(W, stretch):
    return findroot(lambda b: diff(lambda y: W(stretch, y), b), (mpf("0.2"), stretch), solver="anderson")


def main():
    print("law,pull,stretch,tension")
    for law, W in LAWS.items():
        for pull in ("strip", "sheet"):
            for step in range(1, 53 if pull == "strip" else 31):
                stretch = 1 + mpf(step) / 100
                width = natural_width(W, stretch) if pull == "strip" else stretch
                tension = diff(lambda x, W=W, width=width: W(x, width), stretch) / width
                print(f"{law},{pull},{float(stretch):g},{float(tension):.12g}")


if __name__ == "__main__":
    main()
