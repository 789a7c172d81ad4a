"""The main figure's numbers from a CSV export: thresholds by eccentricity and the line omega = m e + omega0.

    parafovea export data --format csv --out tables
    python mar_figure.py tables [--figure mar.png]

For every study and observer with a fit it takes the answered trials of trials.csv, finds the highest point of likelihood times
priors, samples around it, and prints highest point and median beside the medians of fits.csv and thresholds.csv. The model is
written here anew, from its definition:

    psi(e, omega) = 1/2 + (1/2 - lapse) Phi(3.2897 (ln omega - ln(m e + omega0)) / width)
    ln m ~ N(ln 0.025, 1.5), ln omega0 ~ N(ln 1/48, 1.5), ln width ~ N(ln 0.8, 0.8), lapse ~ Beta(1, 10) below 1/2

and for thresholds the same with ln threshold(e) ~ N(ln(0.025 e + 1/48), 1.5) in place of the line. Trials at or below what the
display could show are left out, as the program does; what it could show follows from its size in sessions.csv.

It ends with 1 where its median and the table's are more than 0.15 posterior standard deviations apart (of the logarithm; of
the lapse rate itself; one standard deviation is the 95 % interval over 3.92). Sampling leaves about 0.05 of that. The program
integrates by other means: importance sampling for the line, nested sums for thresholds. The highest point is shown because it
is what a maximum likelihood fit would find; where the posterior is skewed it is not the median, and it is not compared.
Needs pandas, numpy and scipy; --figure needs matplotlib.
"""

import argparse
import sys

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import ndtr, xlogy

SCALE = 3.289707253902945  # Phi^-1(0.95) - Phi^-1(0.05): widths go from 5 % to 95 %
TOLERANCE_SD = 0.15
WALKERS, BURN, STEPS = 200, 500, 2000


def finest_mar(session, eccentricity_deg):
    """Two pixels of the display, in degrees, where a ring of this eccentricity leaves it last."""
    distance = session.distance_mm
    x, y = (distance * np.tan(np.radians([session.fixation_x_deg, session.fixation_y_deg])))
    gaze = np.array([x, y, distance])
    across, slant = np.hypot(x, distance), np.linalg.norm(gaze)
    side = -1.0 if session.fixation_x_deg > 0 else 1.0
    right = np.array([side * distance / across, 0.0, -side * x / across])
    e = np.radians(eccentricity_deg)
    direction = gaze / slant * np.cos(e) + right * np.sin(e)
    place = direction * distance / direction[2]
    pitch = max(session.display_width_mm / session.display_width_px, session.display_height_mm / session.display_height_px)
    return np.degrees(np.arctan(2 * pitch / np.linalg.norm(place)))


def cells(trials, session):
    """Right answers k of n by eccentricity and omega, without what the display could not show."""
    answered = trials[(trials.practice == 0) & (trials.outcome == "answered") & trials.correct.notna() & trials.mar_deg.notna()]
    table = answered.groupby(["eccentricity_deg", "mar_deg"]).correct.agg(["size", "sum"]).reset_index()
    limit = np.array([finest_mar(session, e) for e in table.eccentricity_deg])
    shown = table[table.mar_deg > limit * (1 + 1e-9)]
    return [shown[name].to_numpy(float) for name in ("eccentricity_deg", "mar_deg", "size", "sum")]


def log_posterior(x, ln_threshold, centres, omega, n, k):
    """Of points x, one a row: locations with a prior of SD 1.5 around ln `centres`, then ln width, then the lapse rate."""
    ln_width, lapse = x[:, -2, None], x[:, -1, None]
    inside = (x[:, -1] >= 0) & (x[:, -1] < 0.5)
    lapse = np.where(inside[:, None], lapse, 0.25)
    t = SCALE * (np.log(omega) - ln_threshold(x)) / np.exp(ln_width)
    value = np.sum(xlogy(k, 0.5 + (0.5 - lapse) * ndtr(t)) + xlogy(n - k, lapse + (0.5 - lapse) * ndtr(-t)), axis=1)
    value -= 0.5 * np.sum(((x[:, :-2] - np.log(centres)) / 1.5) ** 2, axis=1)
    value -= 0.5 * ((x[:, -2] - np.log(0.8)) / 0.8) ** 2
    return np.where(inside, value + 9 * np.log1p(-lapse[:, 0]), -np.inf)


def highest(function, start):
    """The maximum; the last parameter is a lapse rate in [0, 0.5)."""
    down = lambda x: min(-function(x[None, :])[0], 1e9)
    best = None
    for lapse in (0.005, 0.05):
        fit = minimize(down, np.append(start, lapse), method="L-BFGS-B", bounds=[(-12, 6)] * len(start) + [(0, 0.499)])
        fit = minimize(down, fit.x, method="Nelder-Mead",
                       options={"xatol": 1e-7, "fatol": 1e-9, "maxiter": 40000, "maxfev": 40000})
        if best is None or fit.fun < best.fun:
            best = fit
    return best.x


def medians(function, start, rng):
    """Posterior medians by differential evolution (ter Braak 2006): each half of the walkers moves along differences of the other."""
    count, half = len(start), WALKERS // 2
    x = start + 0.1 * rng.standard_normal((WALKERS, count))
    x[:, -1] = np.clip(rng.beta(1, 10, WALKERS), 0, 0.49)
    value, kept = function(x), []
    for step in range(BURN + STEPS):
        for own, other in ((slice(0, half), x[half:]), (slice(half, None), x[:half])):
            a, b = rng.integers(half, size=half), rng.integers(half, size=half)
            gamma = 1.0 if step % 10 == 0 else 2.38 / np.sqrt(2 * count)
            there = x[own] + gamma * (other[a] - other[b]) + 1e-4 * rng.standard_normal((half, count))
            value_there = function(there)
            moved = np.log(rng.random(half)) < value_there - value[own]
            x[own] = np.where(moved[:, None], there, x[own])
            value[own] = np.where(moved, value_there, value[own])
        if step >= BURN:
            kept.append(x.copy())
    return np.median(np.concatenate(kept), axis=0)


def fit(ln_threshold, centres, data, rng):
    """Highest point and median of locations, width and lapse."""
    function = lambda x: log_posterior(x, ln_threshold, centres, *data)
    top = highest(function, np.append(np.log(centres), np.log(0.8)))
    return [np.append(np.exp(x[:-1]), x[-1]) for x in (top, medians(function, top, rng))]


def line(e, omega, n, k, rng):
    ln_threshold = lambda x: np.log(np.exp(x[:, 0, None]) * e + np.exp(x[:, 1, None]))
    top, middle = fit(ln_threshold, np.array([0.025, 1 / 48]), (omega, n, k), rng)
    return {name: pair for name, *pair in zip(("m", "omega0", "width", "lapse"), top, middle)}


def thresholds(e, omega, n, k, rng):
    rings, ring = np.unique(e, return_inverse=True)
    top, middle = fit(lambda x: x[:, ring], 0.025 * rings + 1 / 48, (omega, n, k), rng)
    return {e: pair for e, *pair in zip(rings, top, middle)}


def beside(name, own, row, column):
    """One line, and whether the two agree."""
    top, middle = own
    if name == "lapse":
        away = abs(middle - row[column]) / ((row.ci95_high - row.ci95_low) / 3.92)
    else:
        away = abs(np.log(middle / row[column])) / (np.log(row.ci95_high / row.ci95_low) / 3.92)
    print(f"  {name:<8} {top:10.5f} {middle:10.5f} {row[column]:10.5f}   {row.ci95_low:.5f} - {row.ci95_high:.5f}   {away:5.3f} SD")
    return away <= TOLERANCE_SD


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", help="a CSV export")
    parser.add_argument("--figure", help="draw the figure into this file")
    arguments = parser.parse_args()
    read = lambda name: pd.read_csv(f"{arguments.folder}/{name}.csv", dtype={"observer": str, "session": str, "study": str})
    trials, sessions, fits, limits = (read(name) for name in ("trials", "sessions", "fits", "thresholds"))
    if fits.empty:
        sys.exit("fits.csv has no rows: nothing in this export was fitted")
    agree, drawn, rng = True, [], np.random.default_rng(20121119)
    for (study, observer), of_fit in fits.groupby(["study", "observer"]):
        own_sessions = sessions[(sessions.study == study) & (sessions.observer == observer)]
        data = cells(trials[trials.session.isin(own_sessions.session)], own_sessions.iloc[0])
        print(f"{study}, {observer}: {int(data[2].sum())} trials in {len(data[0])} cells")
        print("              highest     median  the table    95 % interval      apart")
        own_line, own_thresholds = line(*data, rng), thresholds(*data, rng)
        for quantity, row in of_fit.set_index("quantity").iterrows():
            agree &= beside(quantity, own_line[quantity], row, "estimate")
        beyond = {}
        for _, row in limits[(limits.study == study) & (limits.observer == observer)].iterrows():
            name, own = f"{row.eccentricity_deg:g} deg", own_thresholds.get(row.eccentricity_deg)
            if row.limited:
                beyond[row.eccentricity_deg] = row.mar_deg
                agree &= bool(own is None or own[1] < row.mar_deg)
                print(f"  {name:<8} finer than the display can show, {row.mar_deg:.5f}" + (f"; here {own[1]:.5f}" if own else ""))
            else:
                agree &= beside(name, own, row, "mar_deg")
        drawn.append((study, observer, own_line, own_thresholds, beyond))
    if arguments.figure:
        draw(drawn, arguments.figure)
    print("agree" if agree else f"DISAGREE: more than {TOLERANCE_SD} posterior standard deviations apart")
    sys.exit(0 if agree else 1)


def draw(drawn, file):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(5, 4), constrained_layout=True)
    for index, (study, observer, fit, points, beyond) in enumerate(drawn):
        color = f"C{index}"
        e = np.linspace(0, max(points) * 1.1, 50)
        axes.plot(e, fit["m"][1] * e + fit["omega0"][1], color=color)
        shown = {ring: middle for ring, (_, middle) in points.items() if ring not in beyond}
        axes.plot(list(shown), list(shown.values()), "o", color=color, label=f"{observer} ({study})")
        # What the display could not show is a limit and no value.
        axes.plot(list(beyond), list(beyond.values()), "v", color=color, fillstyle="none")
    axes.set(xlabel="eccentricity (deg)", ylabel="minimum angle of resolution (deg/cycle)", xlim=(0, None), ylim=(0, None))
    axes.legend()
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    main()
