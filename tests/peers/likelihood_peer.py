"""Maximum likelihood of psychometric functions with profile intervals, as quickpsy fits them, by scipy's optimisers.

Prints the numbers that analysis/tests/psychometric_likelihood.rs holds. Levels, counts and bounds are written out below.
"""

import numpy as np
import scipy
from scipy.optimize import brentq, minimize
from scipy.special import expit, gammaln, ndtr
from scipy.stats import chi2

SHAPES = {
    "gauss": lambda u: ndtr(3.289707253902945 * u),
    "logistic": lambda u: expit(2 * np.log(19) * u),
    "gumbel": lambda u: -np.expm1(-np.log(2) * np.exp((np.log(-np.log(0.05)) - np.log(-np.log(0.95))) * u)),
}

CASES = [
    ("gauss, 2AFC", "gauss", 0.5, False, [1, 2, 3, 4, 5, 6, 7], [40] * 7, [19, 22, 27, 32, 37, 39, 39]),
    ("logistic, yes/no", "logistic", None, False, [1, 2, 3, 4, 5, 6, 7], [30] * 7, [2, 3, 6, 12, 22, 27, 28]),
    ("Weibull, 4AFC, ln level", "gumbel", 0.25, True, [0.05, 0.1, 0.2, 0.4, 0.8, 1.6], [24] * 6, [6, 8, 11, 17, 22, 23]),
]


def fit(shape, guess, x, n, k, hold=None):
    """Best (threshold, ln width, lapse, guess) from several starts; `hold` fixes the threshold."""

    def loss(p):
        t, w, lapse = (hold, *p[:2]) if hold is not None else p[:3]
        g = guess if guess is not None else p[-1]
        s = SHAPES[shape]((x - t) / np.exp(w))
        q = np.clip(g + (1 - g - lapse) * s, 1e-300, 1 - 1e-16)
        return -np.sum(k * np.log(q) + (n - k) * np.log1p(-q))

    best = None
    span = x.max() - x.min()
    for t in np.linspace(x.min(), x.max(), 7):
        for w in np.log(span * np.array([0.2, 0.6, 1.5])):
            start = [] if hold is not None else [t]
            start += [w, 0.02] + ([0.05] if guess is None else [])
            bounds = [] if hold is not None else [(x.min() - 2 * span, x.max() + 2 * span)]
            bounds += [(np.log(1e-3), np.log(30 * span)), (0, 0.5)] + ([(0, 0.5)] if guess is None else [])
            found = minimize(loss, start, bounds=bounds, method="L-BFGS-B", options={"ftol": 1e-15, "gtol": 1e-10, "maxiter": 5000})
            if best is None or found.fun < best.fun:
                best = found
    return best


def main():
    print(f"numpy {np.__version__}, scipy {scipy.__version__}")
    for name, shape, guess, log, levels, n, k in CASES:
        x, n, k = np.log(levels) if log else np.array(levels, float), np.array(n), np.array(k)
        best = fit(shape, guess, x, n, k)
        constant = np.sum(gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1))
        limit = 0.5 * chi2.ppf(0.95, 1)

        def excess(t):
            return fit(shape, guess, x, n, k, hold=t).fun - best.fun - limit

        t = best.x[0]
        span = x.max() - x.min()
        low = brentq(excess, t - 0.5 * span, t, xtol=1e-8)
        high = brentq(excess, t, t + 0.5 * span, xtol=1e-8)
        params = [best.x[0], np.exp(best.x[1])] + list(best.x[2:])
        aic = 2 * len(best.x) - 2 * (constant - best.fun)
        print(name, [f"{p:.7g}" for p in params], f"lnL {constant - best.fun:.8f} AIC {aic:.6f} threshold {low:.7g} {high:.7g}")


if __name__ == "__main__":
    main()
