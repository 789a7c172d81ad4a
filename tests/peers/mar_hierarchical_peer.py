"""The population of MAR lines by other means: numpyro's NUTS over all observers and the population at once.

Written from the model's definition and not from our code. Observer i: psi(e, omega) = g + (1 - g - lam_i)
Phi(3.2897 (ln omega - ln(m_i e + omega0_i)) / w_i), g = 1/2; ln m_i ~ N(mu_m, tau_m) and so on, independent;
mu_m ~ N(ln 0.025, 1.5), mu_omega0 ~ N(ln 1/48, 1.5), mu_w ~ N(ln 0.8, 0.8), each tau ~ half-t(4) of scale 0.5,
lam_i ~ Beta(1, 10) cut at 1/2. Sampled in non-centred coordinates: eta_i = (ln m_i - mu)/tau, ln tau, and ln(lam/(1/2 - lam)). An ensemble sampler (emcee, 120 walkers, 24 000 steps) does
not settle here: its SD of the mean was 20 % too small.

    python mar_hierarchical_peer.py data/mar_group.csv        prints the numbers that README.md and the Rust tests hold
    python mar_hierarchical_peer.py --generate data/mar_group.csv   writes the data set anew (seeded)
"""

import csv
import sys

import jax
import jax.numpy as jnp
import numpy
import numpyro
import numpyro.distributions as dist
from numpyro import infer
from numpyro.diagnostics import summary as summary_of
from jax.scipy.special import ndtr, xlogy

jax.config.update("jax_enable_x64", True)

GUESS = 0.5
CENTER = numpy.log([0.025, 1 / 48, 0.8])
SPREAD = numpy.array([1.5, 1.5, 0.8])
SD_SCALE, SD_DF = 0.5, 4.0
SCALE = 3.289707253902945


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
                    p = GUESS + (1 - GUESS - lapse) * float(ndtr(t))
                    out.writerow([observer, e, omega, 10, rng.binomial(10, p)])


def read(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    observers = sorted({row["observer"] for row in rows})
    return numpy.array([[[float(row[name]) for name in ("eccentricity_deg", "mar_deg", "n", "k")]
                         for row in rows if row["observer"] == observer] for observer in observers])


def model(data):
    e, omega, n, k = (jnp.asarray(data[:, :, i]) for i in range(4))
    observers = data.shape[0]
    mu = numpyro.sample("mu", dist.Normal(jnp.asarray(CENTER), jnp.asarray(SPREAD)).to_event(1))
    # Half-t, written over ln tau with its Jacobian.
    ln_tau = numpyro.sample("ln_tau", dist.ImproperUniform(dist.constraints.real, (), (3,)))
    tau = jnp.exp(ln_tau)
    numpyro.factor("half_t", jnp.sum(-0.5 * (SD_DF + 1) * jnp.log1p((tau / SD_SCALE) ** 2 / SD_DF) + ln_tau))
    eta = numpyro.sample("eta", dist.Normal(jnp.zeros((observers, 3)), 1.0).to_event(2))
    theta = mu + tau * eta
    numpyro.deterministic("ln_m", theta[:, 0])
    # Beta(1, 10) cut at 1/2, over the logit of 2 lambda with its Jacobian.
    logit = numpyro.sample("logit", dist.ImproperUniform(dist.constraints.real, (), (observers,)))
    lapse = 0.5 * jax.nn.sigmoid(logit)
    numpyro.factor("beta", jnp.sum(9 * jnp.log1p(-lapse) + jax.nn.log_sigmoid(logit) + jax.nn.log_sigmoid(-logit)))
    t = SCALE * (jnp.log(omega) - jnp.logaddexp(theta[:, 0:1] + jnp.log(e), theta[:, 1:2])) / jnp.exp(theta[:, 2:3])
    rise = 1 - GUESS - lapse[:, None]
    right = GUESS + rise * ndtr(t)
    wrong = lapse[:, None] + rise * ndtr(-t)
    numpyro.factor("answers", jnp.sum(xlogy(k, right) + xlogy(n - k, jnp.maximum(wrong, 1e-300))))


def main(path, draws=10000):
    data = read(path)
    # The fovea's ln 0 would spoil gradients.
    data[:, :, 0] = numpy.maximum(data[:, :, 0], 1e-12)
    kernel = infer.NUTS(model, target_accept_prob=0.95)
    sampler = infer.MCMC(kernel, num_warmup=1500, num_samples=draws // 4, num_chains=4, chain_method="sequential",
                                 progress_bar=False)
    sampler.run(jax.random.PRNGKey(7), data)
    print(f"python {sys.version.split()[0]}, numpy {numpy.__version__}, jax {jax.__version__}, numpyro {numpyro.__version__}")
    by_chain = sampler.get_samples(group_by_chain=True)
    samples = sampler.get_samples()
    summary = summary_of({key: by_chain[key] for key in ("mu", "ln_tau", "ln_m")})
    for i, name in enumerate(["m", "omega0", "width"]):
        mu, tau = numpy.asarray(samples["mu"][:, i]), numpy.exp(numpy.asarray(samples["ln_tau"][:, i]))
        low, median, high = numpy.exp(numpy.quantile(mu, [0.025, 0.5, 0.975]))
        print(f"mean of ln {name}: {mu.mean():.5f} sd {mu.std():.5f} median {median:.6g} ci95 {low:.6g} {high:.6g} "
              f"(n_eff {summary['mu']['n_eff'][i]:.0f}, R-hat {summary['mu']['r_hat'][i]:.4f})")
        low, median, high = numpy.quantile(tau, [0.025, 0.5, 0.975])
        print(f"SD of ln {name}: median {median:.5f} ci95 {low:.5f} {high:.5f} (n_eff {summary['ln_tau']['n_eff'][i]:.0f}, "
              f"R-hat {summary['ln_tau']['r_hat'][i]:.4f})")
    for observer in range(data.shape[0]):
        ln_m = numpy.asarray(samples["ln_m"][:, observer])
        print(f"observer {observer}: ln m mean {ln_m.mean():.5f} sd {ln_m.std():.5f}")


if __name__ == "__main__":
    if sys.argv[1] == "--generate":
        generate(sys.argv[2])
    else:
        main(sys.argv[1], *map(int, sys.argv[2:]))
