"""The posterior of one psychometric function by dense sums in double precision: numbers for analysis/tests/psychometric.rs.

Model and priors as psignifit has them (Schuett et al. 2016), eta = 0. Prints mode, and 2.5 %, 50 %, 97.5 % of each marginal.
"""

import numpy as np
import scipy
from scipy.optimize import minimize
from scipy.special import ndtr

WIDTH = 3.289707253902945


def ln_prior(m, w, lapse, gamma, x, free):
    low, high = x.min(), x.max()
    spread, step = high - low, np.diff(np.sort(x)).min()
    outside = np.maximum(np.maximum(low - m, m - high), 0)
    threshold = np.where(outside >= spread / 2, 0, 0.5 + 0.5 * np.cos(2 * np.pi * outside / spread))
    width = np.select(
        [(w <= step) | (w >= 3 * spread), w < 2 * step, w <= spread],
        [0, 0.5 - 0.5 * np.cos(np.pi * (w - step) / step), 1],
        0.5 + 0.5 * np.cos(np.pi / 2 * (w - spread) / spread),
    )
    with np.errstate(divide="ignore"):
        rates = 9 * np.log1p(-lapse) + (9 * np.log1p(-gamma) if free else 0)
        return np.log(threshold) + np.log(width) + rates


def ln_likelihood(m, w, lapse, gamma, x, n, k):
    total = 0
    for level, trials, right in zip(x, n, k):
        z = WIDTH * (level - m) / w
        rise = 1 - gamma - lapse
        with np.errstate(divide="ignore", invalid="ignore"):
            total = total + right * np.log(gamma + rise * ndtr(z)) + (trials - right) * np.log(lapse + rise * ndtr(-z))
    return total


def quantiles(nodes, mass):
    edges = np.concatenate([[1.5 * nodes[0] - 0.5 * nodes[1]], 0.5 * (nodes[1:] + nodes[:-1]),
                            [1.5 * nodes[-1] - 0.5 * nodes[-2]]])
    return np.interp([0.025, 0.5, 0.975], np.concatenate([[0], np.cumsum(mass / mass.sum())]), edges)


def posterior(name, x, n, k, gamma, sizes):
    """x rises with the share of right answers; gamma is None where it is free."""
    free = gamma is None
    spread, step = x.max() - x.min(), np.diff(np.sort(x)).min()
    even = lambda low, high, count: low + (np.arange(count) + 0.5) * (high - low) / count
    axes = [
        even(x.min() - spread / 2, x.max() + spread / 2, sizes[0]),
        even(step, 3 * spread, sizes[1]),
        even(0, 0.5, sizes[2]),
        even(0, 0.5, sizes[3]) if free else np.array([gamma]),
    ]
    shape = [len(axis) for axis in axes]
    ln = np.empty(shape)
    w, lapse, g = np.meshgrid(*axes[1:], indexing="ij")
    for i, m in enumerate(axes[0]):
        ln[i] = ln_prior(m, w, lapse, g, x, free) + ln_likelihood(m, w, lapse, g, x, n, k)
    ln[np.isnan(ln)] = -np.inf
    mass = np.exp(ln - ln.max())
    best = [axis[at] for axis, at in zip(axes, np.unravel_index(ln.argmax(), shape))]

    def loss(v):
        m, w, lapse = v[:3]
        g = v[3] if free else gamma
        if lapse < 0 or lapse > 0.5 or g < 0 or g > 0.5:
            return 1e12
        value = -(ln_prior(m, w, lapse, g, x, free) + ln_likelihood(m, w, lapse, g, x, n, k))
        return value if np.isfinite(value) else 1e12

    start = np.array(best[:3] + ([best[3]] if free else []))
    for _ in range(5):
        start = minimize(loss, start, method="Nelder-Mead", options=dict(xatol=1e-10, fatol=1e-12, maxiter=20000)).x
    print(name, "mode", [float(f"{v:.7g}") for v in start])
    for i, label in enumerate(["threshold", "width", "lapse", "guess"][: 4 if free else 3]):
        marginal = mass.sum(axis=tuple(j for j in range(4) if j != i))
        print(f"  {label}: {[float(f'{v:.7g}') for v in quantiles(axes[i], marginal)]}")


print("numpy", np.__version__, "scipy", scipy.__version__)
forced = np.array([19, 22, 27, 32, 37, 39, 39])
posterior("2AFC", np.arange(1.0, 8.0), np.full(7, 40), forced, 0.5, (500, 600, 200, 1))
# A pair comparison in quality index: detection falls with j, so the axis is -j and the threshold's sign turns.
j = np.arange(8.0, 23.0, 2.0)
named = np.array([20, 19, 17, 12, 7, 3, 2, 1])
posterior("pair", -j[::-1], np.full(8, 20), named[::-1], None, (200, 200, 50, 50))
omega = np.log(np.array([0.05, 0.1, 0.2, 0.4, 0.8]))
posterior("log", omega, np.array([12, 30, 28, 30, 15]), np.array([5, 18, 21, 29, 15]), 0.5, (500, 600, 200, 1))
