"""Likelihood ratios of MAR lines by other means: scipy's optimisers on the model's definition.

Straight, quadratic and broken lines on data/mar_constant.csv and data/mar_bent.csv (linearity); shared against separate
m, omega0 and width on the two as conditions. Maximum likelihood without priors; lapse in 0..0.25, ln width in
ln 0.02..ln 20, MAR positive from 0 to the largest eccentricity.

    python mar_lines_peer.py             prints the numbers that README.md and the Rust tests hold
    python mar_lines_peer.py --generate  writes data/mar_bent.csv anew (seeded)
"""

import csv
import os
import sys

import numpy
import scipy
from scipy.optimize import minimize
from scipy.special import ndtr, xlogy
from scipy.stats import norm

GUESS = 0.5
SCALE = norm.ppf(0.95) - norm.ppf(0.05)
HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "data")
FAR = 20.0
WIDTH, LAPSE = (numpy.log(0.02), numpy.log(20.0)), (0.0, 0.25)


def generate(path):
    rng = numpy.random.default_rng(20121121)
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["eccentricity_deg", "mar_deg", "n", "k"])
        for e in (0.0, 5.0, 10.0, 15.0, 20.0):
            threshold = 0.018 + 0.014 * e + 0.0009 * e * e
            for step in range(-3, 4):
                omega = round(float(threshold * numpy.exp(0.25 * step + 0.1)), 6)
                p = GUESS + (1 - GUESS - 0.02) * norm.cdf(SCALE * (numpy.log(omega) - numpy.log(threshold)) / 0.7)
                out.writerow([e, omega, 20, rng.binomial(20, p)])


def read(name):
    with open(os.path.join(HERE, name)) as file:
        rows = list(csv.DictReader(file))
    return [numpy.array([float(row[key]) for row in rows]) for key in ("eccentricity_deg", "mar_deg", "n", "k")]


def ln_likelihood(threshold, ln_width, lapse, data):
    e, omega, n, k = data
    omega_at = threshold(e)
    if not numpy.all(omega_at > 0):
        return -1e9
    t = SCALE * (numpy.log(omega) - numpy.log(omega_at)) / numpy.exp(ln_width)
    rise = 1 - GUESS - lapse
    return float((xlogy(k, GUESS + rise * ndtr(t)) + xlogy(n - k, lapse + rise * ndtr(-t))).sum())


def best(objective, starts, bounds):
    """The highest of several starts: bounded quasi-Newton, then the simplex until nothing moves."""
    top = None
    for start in starts:
        x = numpy.array(start, float)
        for _ in range(4):
            fit = minimize(objective, x, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-9})
            fit = minimize(objective, fit.x, method="Nelder-Mead", bounds=bounds,
                           options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 40000, "maxfev": 40000})
            x = fit.x
        if top is None or fit.fun < top.fun:
            top = fit
    return top


def linearity(name):
    data = read(name)
    shape = [WIDTH, LAPSE]

    # Line by its ends; quadratic by its values at 0, half way and the end, positive on a fine grid.
    line = best(lambda p: -ln_likelihood(lambda e: p[0] * (1 - e / FAR) + p[1] * e / FAR, p[2], p[3], data),
                [[0.02, 0.45, -0.2, 0.02], [0.02, 0.6, -0.4, 0.01]], [(1e-6, 5), (1e-6, 5)] + shape)
    near, far = line.x[:2]
    grid = numpy.linspace(0, FAR, 401)

    def quadratic(p):
        def curve(e):
            s = e / FAR
            return p[0] * (1 - s) * (1 - 2 * s) + 4 * p[1] * s * (1 - s) + p[2] * s * (2 * s - 1)
        return 1e9 if (curve(grid) <= 0).any() else -ln_likelihood(curve, p[3], p[4], data)

    bent = best(quadratic, [[near, 0.5 * (near + far) * f, far, line.x[2], line.x[3]] for f in (1.0, 0.8, 1.2)],
                [(1e-6, 5)] * 3 + shape)
    print(f"{name}: line {-line.fun:.7f} omega0 {near:.7f} m {(far - near) / FAR:.8f}")
    omega0, middle, end = bent.x[:3]
    print(f"  quadratic {-bent.fun:.7f} difference {2 * (line.fun - bent.fun):.7f} omega0 {omega0:.7f} "
          f"m {(4 * middle - 3 * omega0 - end) / FAR:.8f} q {2 * (end - 2 * middle + omega0) / FAR**2:.9f}")
    for at in (5.0, 8.75, 10.0, 15.0):
        def broken(p):
            return -ln_likelihood(lambda e: numpy.interp(e, [0, at, FAR], p[:3]), p[3], p[4], data)
        start = near + (far - near) * at / FAR
        fit = best(broken, [[near, start * f, far, line.x[2], line.x[3]] for f in (1.0, 0.8, 1.2)], [(1e-6, 5)] * 3 + shape)
        print(f"  break at {at:g}: difference {2 * (line.fun - fit.fun):.7f}")


def conditions():
    data = [read("mar_constant.csv"), read("mar_bent.csv")]
    fits = {}
    for name, shared in (("separate", ()), ("all", (0, 1, 2)), ("m", (0,)), ("omega0", (1,)), ("width", (2,))):
        index, bounds = {}, []
        for parameter, bound in enumerate([(-12, 2), (-12, 2), WIDTH]):
            for condition in range(2):
                if parameter in shared and condition == 1:
                    index[parameter, 1] = index[parameter, 0]
                else:
                    index[parameter, condition] = len(bounds)
                    bounds.append(bound)
        bounds.append(LAPSE)

        def objective(p):
            return -sum(ln_likelihood(
                lambda e: numpy.exp(p[index[0, c]]) * e + numpy.exp(p[index[1, c]]), p[index[2, c]], p[-1], data[c])
                for c in range(2))

        start = numpy.full(len(bounds), 0.02)
        for (parameter, condition), i in index.items():
            start[i] = [numpy.log(0.022), numpy.log(0.02), -0.3][parameter]
        fits[name] = best(objective, [start, start + 0.01], bounds).fun
    for name in ("all", "m", "omega0", "width"):
        print(f"conditions, {name} shared: difference {2 * (fits[name] - fits['separate']):.7f}")


if __name__ == "__main__":
    if sys.argv[1:] == ["--generate"]:
        generate(os.path.join(HERE, "mar_bent.csv"))
    else:
        print(f"python {sys.version.split()[0]}, numpy {numpy.__version__}, scipy {scipy.__version__}")
        linearity("mar_constant.csv")
        linearity("mar_bent.csv")
        conditions()
