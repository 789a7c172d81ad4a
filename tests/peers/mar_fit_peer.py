"""The MAR posterior and its mode by other means: scipy for the mode, dense numpy grids for the integrals.

Written from the model's definition and not from our code:
psi(e, omega) = g + (1 - g - lam) Phi(3.2897 (ln omega - ln(m e + omega0)) / w), g = 1/2,
ln m ~ N(ln 0.025, 1.5), ln omega0 ~ N(ln 1/48, 1.5), ln w ~ N(ln 0.8, 0.8), lam ~ Beta(1, 10) cut at 1 - g.

    python mar_fit_peer.py data/mar_constant.csv        prints the numbers that README.md and the Rust tests hold
    python mar_fit_peer.py --generate data/mar_constant.csv   writes the data set anew (seeded)
"""

import csv
import sys

import numpy
import scipy
import scipy.integrate
import scipy.interpolate
import scipy.special
from scipy.optimize import minimize
from scipy.special import xlogy
from scipy.stats import norm

GUESS = 0.5
PRIOR = [(numpy.log(0.025), 1.5), (numpy.log(1 / 48), 1.5), (numpy.log(0.8), 0.8)]
SCALE = norm.ppf(0.95) - norm.ppf(0.05)


def generate(path):
    rng = numpy.random.default_rng(20121119)
    m, omega0, w, lapse = 0.022, 1 / 48, 0.8, 0.02
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["eccentricity_deg", "mar_deg", "n", "k"])
        for e in (0.0, 5.0, 10.0, 15.0, 20.0):
            centre = (m * e + omega0) * numpy.exp(rng.uniform(-0.2, 0.2))
            for step in range(-3, 4):
                omega = round(float(centre * numpy.exp(0.25 * step)), 6)
                p = GUESS + (1 - GUESS - lapse) * norm.cdf(SCALE * (numpy.log(omega) - numpy.log(m * e + omega0)) / w)
                out.writerow([e, omega, 20, rng.binomial(20, p)])


def read(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return [numpy.array([float(row[name]) for row in rows]) for name in ("eccentricity_deg", "mar_deg", "n", "k")]


def log_posterior(ln_m, ln_omega0, ln_w, lapse, data):
    """Density over (ln m, ln omega0, ln w, lambda), broadcast over the parameters."""
    total = 9 * numpy.log1p(-lapse)
    for value, (mean, sd) in zip((ln_m, ln_omega0, ln_w), PRIOR):
        total = total - 0.5 * ((value - mean) / sd) ** 2
    for e, omega, n, k in zip(*data):
        t = SCALE * (numpy.log(omega) - numpy.log(numpy.exp(ln_m) * e + numpy.exp(ln_omega0))) / numpy.exp(ln_w)
        right = GUESS + (1 - GUESS - lapse) * norm.cdf(t)
        wrong = lapse + (1 - GUESS - lapse) * norm.sf(t)
        total = total + xlogy(k, right) + xlogy(n - k, wrong)
    return total


def mode(data):
    best = None
    for lapse in (0.001, 0.02, 0.1):
        start = [mean for mean, _ in PRIOR] + [lapse]
        bounds = [(-12, 4)] * 3 + [(0, 0.499)]
        options = {"ftol": 1e-15, "gtol": 1e-10, "maxiter": 5000}
        fit = minimize(lambda x: -log_posterior(*x, data), start, method="L-BFGS-B", bounds=bounds, options=options)
        fit = minimize(lambda x: -log_posterior(*x, data) if 0 <= x[3] < 0.5 else 1e9, fit.x, method="Nelder-Mead",
                       options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 20000})
        if best is None or fit.fun < best.fun:
            best = fit
    return best.x, -best.fun


def quantiles(grid, density, probabilities):
    """Trapezoid cumulative on a uniform grid, refined by a cubic spline of ln density."""
    spline = scipy.interpolate.CubicSpline(grid, numpy.log(numpy.maximum(density, 1e-300)))
    fine = numpy.linspace(grid[0], grid[-1], 40001)
    mass = numpy.exp(spline(fine))
    cumulative = scipy.integrate.cumulative_trapezoid(mass, fine, initial=0)
    return numpy.interp(numpy.array(probabilities) * cumulative[-1], cumulative, fine)


def report(name, grid, density, transform=lambda x: x):
    ends = quantiles(grid, density / density.sum(), [0.025, 0.5, 0.975])
    density = density.copy()
    density[[0, -1]] *= 0.5  # trapezoids, for a density that ends at lambda = 0
    density = density / density.sum()
    mean = (grid * density).sum()
    sd = numpy.sqrt(((grid - mean) ** 2 * density).sum())
    low, median, high = transform(ends)
    print(f"{name}: mean {mean:.6f} sd {sd:.6f} median {median:.8g} ci95 {low:.8g} {high:.8g}")


def integrate(data):
    ln_m = numpy.linspace(-4.6, -3.2, 49)
    ln_omega0 = numpy.linspace(-5.4, -3.0, 57)
    ln_w = numpy.linspace(-1.6, 1.2, 43)
    lapse = numpy.linspace(0, 0.2, 61)
    density = numpy.empty((len(ln_m), len(ln_omega0), len(ln_w), len(lapse)))
    for i, value in enumerate(ln_m):
        density[i] = log_posterior(value, ln_omega0[:, None, None], ln_w[None, :, None], lapse[None, None, :], data)
    density = numpy.exp(density - density.max())
    lapse_density = density.sum(axis=(0, 1, 2))
    density[..., [0, -1]] *= 0.5
    report("ln_m", ln_m, density.sum(axis=(1, 2, 3)), numpy.exp)
    report("ln_omega0", ln_omega0, density.sum(axis=(0, 2, 3)), numpy.exp)
    report("ln_width", ln_w, density.sum(axis=(0, 1, 3)), numpy.exp)
    report("lapse", lapse, lapse_density)


def thresholds(data):
    """One threshold per eccentricity, width and lapse shared; prior ln t ~ N(ln(0.025 e + 1/48), 1.5)."""
    ln_w = numpy.linspace(-1.8, 1.2, 61)
    lapse = numpy.linspace(0, 0.3, 91)
    log_prior = (-0.5 * ((ln_w - PRIOR[2][0]) / PRIOR[2][1]) ** 2)[:, None] + 9 * numpy.log1p(-lapse)
    tables, weight = [], log_prior
    for e in numpy.unique(data[0]):
        centre = numpy.log(0.025 * e + 1 / 48)
        ln_t = numpy.linspace(centre - 1.8, centre + 1.4, 241)
        value = numpy.broadcast_to((-0.5 * ((ln_t - centre) / 1.5) ** 2)[:, None, None], (241, len(ln_w), len(lapse))).copy()
        for _, omega, n, k in [row for row in zip(*data) if row[0] == e]:
            t = (SCALE * (numpy.log(omega) - ln_t)[:, None] / numpy.exp(ln_w))[:, :, None]
            value += xlogy(k, GUESS + (1 - GUESS - lapse) * norm.cdf(t))
            value += xlogy(n - k, lapse + (1 - GUESS - lapse) * norm.sf(t))
        evidence = scipy.special.logsumexp(value, axis=0)
        tables.append((e, ln_t, value - evidence))
        weight = weight + evidence
    weight = numpy.exp(weight - weight.max())
    weight[:, [0, -1]] *= 0.5
    for e, ln_t, value in tables:
        report(f"ln_threshold_{e:g}", ln_t, (numpy.exp(value) * weight).sum(axis=(1, 2)), numpy.exp)


if __name__ == "__main__":
    if sys.argv[1] == "--generate":
        generate(sys.argv[2])
    else:
        print(f"python {sys.version.split()[0]}, numpy {numpy.__version__}, scipy {scipy.__version__}")
        data = read(sys.argv[1])
        x, value = mode(data)
        print(f"map: m {numpy.exp(x[0]):.9g} omega0 {numpy.exp(x[1]):.9g} width {numpy.exp(x[2]):.9g} "
              f"lapse {x[3]:.6g} log density {value:.9g}")
        integrate(data)
        thresholds(data)
