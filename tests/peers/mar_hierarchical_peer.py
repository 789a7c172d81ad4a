"""The population of MAR lines by other means: emcee over all observers and the population at once.

Written from the model's definition and not from our code. Observer i: psi(e, omega) = g + (1 - g - lam_i)
Phi(3.2897 (ln omega - ln(m_i e + omega0_i)) / w_i), g = 1/2; ln m_i ~ N(mu_m, tau_m) and so on, independent;
mu_m ~ N(ln 0.025, 1.5), mu_omega0 ~ N(ln 1/48, 1.5), mu_w ~ N(ln 0.8, 0.8), each tau ~ half-t(4) of scale 0.3,
lam_i ~ Beta(1, 10) cut at 1/2. Sampled in non-centred coordinates: eta_i = (ln m_i - mu)/tau, ln tau, and ln(lam/(1/2 - lam)).

    python mar_hierarchical_peer.py data/mar_group.csv        prints the numbers that README.md and the Rust tests hold
    python mar_hierarchical_peer.py --generate data/mar_group.csv   writes the data set anew (seeded)
"""

import csv
import sys

import emcee
import numpy
import scipy
from scipy.special import ndtr
from scipy.stats import norm

GUESS = 0.5
CENTER = numpy.log([0.025, 1 / 48, 0.8])
SPREAD = numpy.array([1.5, 1.5, 0.8])
SD_SCALE, SD_DF = 0.3, 4.0
SCALE = norm.ppf(0.95) - norm.ppf(0.05)


def generate(path):
    rng = numpy.random.default_rng(20121120)
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["observer", "eccentricity_deg", "mar_deg", "n", "k"])
        for observer in range(6):
            m, omega0, w = numpy.exp(numpy.log([0.022, 1 / 48, 0.8]) + rng.normal(size=3) * [0.25, 0.3, 0.25])
            lapse = rng.beta(1, 20)
            for e in (0.0, 5.0, 10.0, 15.0, 20.0):
                for step in range(-3, 4):
                    omega = round(float((0.022 * e + 1 / 48) * numpy.exp(0.27 * step)), 6)
                    t = SCALE * (numpy.log(omega) - numpy.log(m * e + omega0)) / w
                    p = GUESS + (1 - GUESS - lapse) * norm.cdf(t)
                    out.writerow([observer, e, omega, 10, rng.binomial(10, p)])


def read(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    observers = sorted({row["observer"] for row in rows})
    return numpy.array([[[float(row[name]) for name in ("eccentricity_deg", "mar_deg", "n", "k")]
                         for row in rows if row["observer"] == observer] for observer in observers])


def log_posterior(x, data):
    """x: (walkers, 6 + 4 N)."""
    observers = data.shape[0]
    mu, ln_tau = x[:, :3], x[:, 3:6]
    eta = x[:, 6:].reshape(-1, observers, 4)
    tau = numpy.exp(ln_tau)
    theta = mu[:, None, :] + tau[:, None, :] * eta[:, :, :3]
    logit = eta[:, :, 3]
    lapse = 0.5 / (1 + numpy.exp(-logit))
    total = -0.5 * (((mu - CENTER) / SPREAD) ** 2).sum(axis=1)
    total += (-0.5 * (SD_DF + 1) * numpy.log1p((tau / SD_SCALE) ** 2 / SD_DF) + ln_tau).sum(axis=1)
    total += -0.5 * (eta[:, :, :3] ** 2).sum(axis=(1, 2))
    # Beta(1, 10) density of lambda and the Jacobian of its logit on 0..1/2.
    total += (9 * numpy.log1p(-lapse) + numpy.log(lapse) + numpy.log(0.5 - lapse)).sum(axis=1)
    e, omega, n, k = (data[None, :, :, i] for i in range(4))
    with numpy.errstate(all="ignore"):
        threshold = numpy.log(numpy.exp(theta[:, :, 0:1]) * e + numpy.exp(theta[:, :, 1:2]))
        t = SCALE * (numpy.log(omega) - threshold) / numpy.exp(theta[:, :, 2:3])
        rise = 1 - GUESS - lapse[:, :, None]
        right = GUESS + rise * ndtr(t)
        wrong = lapse[:, :, None] + rise * ndtr(-t)
        total += (k * numpy.log(right) + (n - k) * numpy.log(numpy.maximum(wrong, 1e-300))).sum(axis=(1, 2))
    return numpy.where(numpy.isfinite(total), total, -numpy.inf)


def main(path, steps=24000):
    data = read(path)
    observers = data.shape[0]
    dims = 6 + 4 * observers
    rng = numpy.random.default_rng(7)
    walkers = 4 * dims
    start = numpy.concatenate(
        [numpy.tile(CENTER, (walkers, 1)) + rng.normal(size=(walkers, 3)) * 0.1,
         numpy.log(0.25) + rng.normal(size=(walkers, 3)) * 0.3,
         rng.normal(size=(walkers, 4 * observers)) * 0.4 + numpy.tile([0, 0, 0, -3.0], observers)], axis=1)
    moves = [(emcee.moves.DEMove(), 0.7), (emcee.moves.DEMove(gamma0=1.0), 0.1), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(walkers, dims, lambda x: log_posterior(x, data), moves=moves, vectorize=True)
    numpy.random.seed(7)
    sampler.run_mcmc(start, steps, skip_initial_state_check=True)
    chain = sampler.get_chain(discard=steps // 4)
    print(f"python {sys.version.split()[0]}, numpy {numpy.__version__}, scipy {scipy.__version__}, emcee {emcee.__version__}")
    tau = emcee.autocorr.integrated_time(chain[:, :, :6], quiet=True)
    flat = chain.reshape(-1, dims)
    effective = flat.shape[0] / tau
    for i, name in enumerate(["m", "omega0", "width"]):
        mu = flat[:, i]
        low, median, high = numpy.exp(numpy.quantile(mu, [0.025, 0.5, 0.975]))
        print(f"mean of ln {name}: {mu.mean():.5f} sd {mu.std():.5f} median {median:.6g} ci95 {low:.6g} {high:.6g} "
              f"({effective[i]:.0f} effective draws)")
        sd = numpy.exp(flat[:, 3 + i])
        low, median, high = numpy.quantile(sd, [0.025, 0.5, 0.975])
        print(f"SD of ln {name}: median {median:.5f} ci95 {low:.5f} {high:.5f} ({effective[3 + i]:.0f})")
    for observer in range(observers):
        ln_m = flat[:, 0] + numpy.exp(flat[:, 3]) * flat[:, 6 + 4 * observer]
        print(f"observer {observer}: ln m mean {ln_m.mean():.5f} sd {ln_m.std():.5f}")


if __name__ == "__main__":
    if sys.argv[1] == "--generate":
        generate(sys.argv[2])
    else:
        main(sys.argv[1], *map(int, sys.argv[2:]))
