"""Tests and intervals of `analysis::statistics` by other programs: writes analysis/tests/statistics_numbers.json.

Distributions by mpmath; t, binomial and rank tests by scipy; adjusted p values by statsmodels; analyses of variance by
statsmodels (F), pingouin (one and two factors), R's car (all, through statistics_peer.R) and by sums over projections here.
Takes no argument and about a minute; needs Rscript with car on the path.
"""

import itertools
import json
import pathlib
import subprocess
import tempfile
import warnings

import mpmath as mp
import numpy as np
import pandas as pd
import pingouin as pg
from scipy import optimize, stats
from statsmodels.stats.anova import AnovaRM
from statsmodels.stats.multitest import multipletests

HERE = pathlib.Path(__file__).parent
OUT = HERE.parent.parent / "analysis" / "tests" / "statistics_numbers.json"
mp.mp.dps = 50


# Distributions ------------------------------------------------------------------------------------------------------

def both(lower, upper):
    return [float(lower), float(upper)]


def t_tails(t, df):
    t, df = mp.mpf(t), mp.mpf(df)
    beyond = mp.betainc(df / 2, mp.mpf(1) / 2, 0, df / (df + t * t), regularized=True) / 2
    return both(1 - beyond, beyond) if t >= 0 else both(beyond, 1 - beyond)


def f_tails(x, a, b):
    x, a, b = mp.mpf(x), mp.mpf(a), mp.mpf(b)
    at = a * x / (a * x + b)
    return both(mp.betainc(a / 2, b / 2, 0, at, regularized=True), mp.betainc(b / 2, a / 2, 0, 1 - at, regularized=True))


def chi_square_tails(x, df):
    x, df = mp.mpf(x), mp.mpf(df)
    return both(mp.gammainc(df / 2, 0, x / 2, regularized=True), mp.gammainc(df / 2, x / 2, mp.inf, regularized=True))


def binomial_tails(k, n, p):
    p = mp.mpf(p)

    def tail(start, step):
        """From `start` outwards, term by term, until terms no longer count."""
        term = mp.exp(mp.loggamma(n + 1) - mp.loggamma(start + 1) - mp.loggamma(n - start + 1) + start * mp.log(p) + (n - start) * mp.log(1 - p))
        total, i = mp.mpf(0), start
        while 0 <= i <= n and (term > total * mp.mpf(10) ** -40 or step * (i - n * p) < 0):
            total += term
            term *= (n - i) * p / ((i + 1) * (1 - p)) if step > 0 else i * (1 - p) / ((n - i + 1) * p)
            i += step
        return total

    # Through the middle the sum would be long: the larger tail is one minus the smaller.
    if k < n * p:
        lower = tail(k, -1)
        return both(lower, 1 - lower)
    upper = tail(k + 1, 1)
    return both(1 - upper, upper)


def noncentral_t_tails(t, df, delta):
    t, df, delta = mp.mpf(t), mp.mpf(df), mp.mpf(delta)
    constant = 2 * (df / 2) ** (df / 2) / mp.gamma(df / 2)
    density = lambda s: constant * s ** (df - 1) * mp.exp(-df * s * s / 2)
    sd = 1 / mp.sqrt(2 * df)
    knots = sorted({mp.mpf(0), *[max(mp.mpf(0), 1 + i * sd) for i in range(-12, 25, 4)]})
    if t != 0 and delta / t > 0:
        knots = sorted({*knots, *[max(mp.mpf(0), (delta + i) / t) for i in range(-12, 13, 4)]})
    with mp.workdps(25):
        lower = mp.quad(lambda s: density(s) * mp.ncdf(t * s - delta), knots, maxdegree=5)
        upper = mp.quad(lambda s: density(s) * mp.ncdf(delta - t * s), knots, maxdegree=5)
    assert abs(lower + upper - 1) < mp.mpf(10) ** -18, (t, df, delta, lower + upper - 1)
    return both(lower, upper)


def noncentral_f_tails(x, a, b, lam):
    x, a, b, lam = mp.mpf(x), mp.mpf(a), mp.mpf(b), mp.mpf(lam)
    at = a * x / (a * x + b)
    lower = upper = mp.mpf(0)
    j, weight, done = 0, mp.exp(-lam / 2), False
    while not done:
        low = mp.betainc(a / 2 + j, b / 2, 0, at, regularized=True)
        high = mp.betainc(b / 2, a / 2 + j, 0, 1 - at, regularized=True)
        lower, upper = lower + weight * low, upper + weight * high
        done = j > lam and weight < mp.mpf(10) ** -30 * min(lower, upper)
        j += 1
        weight *= lam / 2 / j
    return both(lower, upper)


def distributions():
    cases = {
        "t": (t_tails, [(0.5, 3), (2.2, 11), (-4, 2.5), (12, 30), (40, 14), (1e5, 5), (25, 1000), (1.96, 1e6)]),
        "f": (f_tails, [(0.01, 2, 22), (1, 1, 7), (5.2, 3, 24), (3.3, 1.7, 18.4), (80, 6, 66), (4e4, 9, 90), (1.05, 4e3, 9e3)]),
        "chi_square": (chi_square_tails, [(0.02, 3), (5.99, 2), (60, 4), (900, 20), (2, 90), (1100, 1000), (9.3, 5)]),
        "binomial": (binomial_tails, [(31, 40, 0.5), (9, 40, 0.25), (0, 30, 0.2), (199, 1000, 0.5), (3, 3000, 0.02),
                                      (501000, 1000000, 0.5), (400, 1000000, 0.0003), (660000, 1000000, 0.65)]),
        "noncentral_t": (noncentral_t_tails, [(2, 11, 1.5), (0.5, 3, -1), (-1, 8, 2), (6, 14, 3), (20, 5, 12), (9, 200, 2),
                                              (3, 1, 1), (-6, 30, 3), (40, 60, 45), (1.2, 9, 8)]),
        "noncentral_f": (noncentral_f_tails, [(3, 2, 22, 5), (0.05, 3, 24, 9), (12, 6, 66, 4), (30, 1, 11, 40), (2, 4, 60, 60),
                                              (200, 9, 90, 30)]),
    }
    return [{"name": name, "arguments": list(args), "tails": tails(*args)}
            for name, (tails, all_args) in cases.items() for args in all_args]


# Counts -------------------------------------------------------------------------------------------------------------

def binomials():
    tests, intervals = [], []
    for k, n, p in [(31, 40, 0.5), (9, 40, 0.25), (0, 12, 0.3), (12, 12, 0.9), (53, 70, 0.5), (37, 70, 0.5), (20, 40, 0.5), (3, 10, 0.3),
                    (7, 100, 0.01), (450, 1000, 0.5), (500600, 1000000, 0.5), (499, 1000000, 0.0004), (999, 1000, 0.98)]:
        for alternative in ["two-sided", "greater", "less"]:
            tests.append({"k": k, "n": n, "null": p, "alternative": alternative,
                          "p": float(stats.binomtest(k, n, p, alternative).pvalue)})
    for k, n in [(0, 20), (1, 29), (15, 148), (81, 263), (20, 20), (500600, 1000000), (3, 1000000)]:
        for confidence in [0.8, 0.95, 0.999]:
            found = stats.binomtest(k, n)
            # scipy's own exact ends are solved to 1e-12 absolute; the beta quantile is good to the last digits.
            outside = (1 - confidence) / 2
            exact = [float(stats.beta.ppf(outside, k, n - k + 1)) if k else 0.0, float(stats.beta.isf(outside, k + 1, n - k)) if k < n else 1.0]
            own = found.proportion_ci(confidence, "exact")
            assert np.allclose(exact, [own.low, own.high], atol=1e-9)
            wilson = found.proportion_ci(confidence, "wilson")
            intervals.append({"k": k, "n": n, "confidence": confidence, "exact": exact, "wilson": [float(wilson.low), float(wilson.high)]})
    return tests, intervals


def adjusted():
    rng = np.random.Generator(np.random.PCG64(2016))
    families = [[0.52, 0.12, 0.0001, 0.03, 0.14], [0.02, 0.02, 0.02, 0.5], [1.0, 0.0, 1e-30], [0.04],
                list(np.round(rng.uniform(0, 0.2, 25), 3))]
    names = {"bonferroni": "bonferroni", "holm": "holm", "benjamini_hochberg": "fdr_bh"}
    return [{"p": [float(p) for p in family], "method": ours, "adjusted": [float(p) for p in multipletests(family, method=theirs)[1]]}
            for family in families for ours, theirs in names.items()]


# t tests ------------------------------------------------------------------------------------------------------------

def noncentralities(tails, observed, low, high, outside=0.025):
    """Where `tails(observed, λ)` = P(X ≤ observed) is 1 − outside and outside."""
    ends = []
    for goal, of in [(outside, lambda at: 1 - tails(observed, at)), (outside, lambda at: tails(observed, at))]:
        error = lambda at: float(of(at)) - goal
        ends.append(0.0 if low == 0 and error(0) * error(high) > 0 else optimize.brentq(error, low, high, xtol=1e-13, rtol=1e-14))
    return [float(end) for end in ends]


def t_limits(t, df):
    return noncentralities(lambda t, delta: stats.nct.cdf(t, df, delta), t, t - 10 - abs(t), t + 10 + abs(t))


def t_tests():
    rng = np.random.Generator(np.random.PCG64(1908))
    result = []
    for n1, n2, shift, scale in [(12, 12, 0.5, 1), (5, 5, 1.5, 3), (20, 20, -0.2, 0.4), (2, 2, 1, 1), (15, 9, 0.8, 2), (40, 6, 0.1, 0.3)]:
        subject = rng.normal(0, 1, max(n1, n2))
        first = np.round(subject[:n1] + rng.normal(shift, scale, n1), 4)
        second = np.round(subject[:n2] + rng.normal(0, 1, n2), 4)
        designs = {"welch": lambda **o: stats.ttest_ind(first, second, equal_var=False, **o), "one_sample": lambda **o: stats.ttest_1samp(first, 0.25, **o)}
        if n1 == n2:
            designs["paired"] = lambda **o: stats.ttest_rel(first, second, **o)
        for design, run in designs.items():
            found = run()
            t, df = float(found.statistic), float(found.df)
            ci = found.confidence_interval(0.95)
            v1, v2 = first.var(ddof=1), second.var(ddof=1)
            average = np.sqrt((v1 + v2) / 2)
            entry = {"design": design, "first": first.tolist(), "second": second.tolist(), "t": t, "df": df, "p": float(found.pvalue),
                     "greater": float(run(alternative="greater").pvalue), "less": float(run(alternative="less").pvalue),
                     "ci": [float(ci.low), float(ci.high)]}
            if design == "welch":
                pooled_df = n1 + n2 - 2
                pooled = np.sqrt(((n1 - 1) * v1 + (n2 - 1) * v2) / pooled_df)
                student = float(stats.ttest_ind(first, second).statistic)
                root = np.sqrt(1 / n1 + 1 / n2)
                assert np.isclose(student * root, pg.compute_effsize(first, second, paired=False, eftype="cohen"))
                error = np.sqrt(v1 / n1 + v2 / n2)
                entry["pooled"] = [student * root, *[end * root for end in t_limits(student, pooled_df)]]
                entry["average"] = [t * error / average, *[end * error / average for end in t_limits(t, df)]]
                entry["pooled_g"] = entry["pooled"][0] * hedges(pooled_df)
            else:
                entry["differences"] = [t / np.sqrt(n1), *[end / np.sqrt(n1) for end in t_limits(t, df)]]
                if df > 1:
                    entry["differences_g"] = entry["differences"][0] * hedges(df)
                if design == "paired":
                    error = (first - second).std(ddof=1) / np.sqrt(n1)
                    assert np.isclose(t * error / average, pg.compute_effsize(first, second, paired=True, eftype="cohen"))
                    entry["average"] = [t * error / average, *[end * error / average for end in t_limits(t, df)]]
            result.append(json.loads(json.dumps(entry, default=float)))
    return result


def hedges(df):
    return float(mp.gamma(mp.mpf(df) / 2) / mp.sqrt(mp.mpf(df) / 2) / mp.gamma((mp.mpf(df) - 1) / 2))


# Ranks --------------------------------------------------------------------------------------------------------------

def tails_of(sums, seen):
    """p of a statistic among all equally probable ones."""
    most, least = float(np.mean(sums <= seen)), float(np.mean(sums >= seen))
    return {"two-sided": min(1.0, 2 * min(most, least)), "greater": least, "less": most}


def all_signs(first, second, zeros):
    differences = first - second
    if zeros == "wilcox":
        differences = differences[differences != 0]
    ranks = stats.rankdata(abs(differences))[differences != 0]
    signs = (np.arange(2 ** len(ranks))[:, None] >> np.arange(len(ranks))) & 1
    return tails_of(signs @ ranks, ranks[differences[differences != 0] > 0].sum())


def all_divisions(first, second):
    ranks = stats.rankdata(np.concatenate([first, second]))
    sums = np.array([ranks[list(chosen)].sum() for chosen in itertools.combinations(range(len(ranks)), len(first))])
    return tails_of(sums, ranks[: len(first)].sum())


def ranks():
    rng = np.random.Generator(np.random.PCG64(1945))
    signed, two, rows = [], [], []
    for n, ties in [(6, False), (12, False), (30, False), (50, False), (11, True), (13, True), (80, True)]:
        first, second = rng.normal(0.4, 1, n), rng.normal(0, 1, n)
        if ties:
            first, second = np.round(2 * first), np.round(2 * second)
        else:
            first, second = np.round(first, 5), np.round(second, 5)
        for zeros in ["wilcox", "pratt"]:
            for alternative in ["two-sided", "greater", "less"]:
                for continuity in [False, True]:
                    found = stats.wilcoxon(first, second, zero_method=zeros, correction=continuity, method="asymptotic", alternative=alternative)
                    signed.append({"first": first.tolist(), "second": second.tolist(), "zeros": zeros, "alternative": alternative,
                                   "method": "continuity" if continuity else "normal", "statistic": float(found.statistic), "p": float(found.pvalue),
                                   "rank_biserial": float(pg.wilcoxon(first, second)["RBC"].iloc[0]) if zeros == "wilcox" else None})
                if not ties or n <= 13:
                    # scipy is exact without ties; with them, all 2ⁿ signs are counted here.
                    p = all_signs(first, second, zeros)[alternative] if ties else float(stats.wilcoxon(first, second, method="exact", alternative=alternative).pvalue)
                    signed.append({"first": first.tolist(), "second": second.tolist(), "zeros": zeros, "alternative": alternative,
                                   "method": "exact", "statistic": None, "p": p, "rank_biserial": None})
    for n1, n2, ties in [(5, 7, False), (12, 9, False), (6, 5, True), (40, 30, True)]:
        first, second = rng.normal(0.5, 1, n1), rng.normal(0, 1.5, n2)
        first, second = (np.round(2 * first), np.round(2 * second)) if ties else (np.round(first, 5), np.round(second, 5))
        for alternative in ["two-sided", "greater", "less"]:
            methods = {"continuity": dict(method="asymptotic", use_continuity=True), "normal": dict(method="asymptotic", use_continuity=False)}
            if not ties:
                methods["exact"] = dict(method="exact")
            for method, options in methods.items():
                found = stats.mannwhitneyu(first, second, alternative=alternative, **options)
                two.append({"first": first.tolist(), "second": second.tolist(), "alternative": alternative, "method": method,
                            "u": float(found.statistic), "p": float(found.pvalue)})
            if ties and n1 + n2 < 15:
                two.append({"first": first.tolist(), "second": second.tolist(), "alternative": alternative, "method": "exact",
                            "u": float(found.statistic), "p": all_divisions(first, second)[alternative]})
    for n, k, ties in [(12, 3, False), (9, 5, True), (20, 4, True)]:
        table = rng.normal(np.linspace(0, 0.8, k), 1, (n, k))
        table = np.round(table) if ties else np.round(table, 4)
        found = stats.friedmanchisquare(*table.T)
        frame = pd.DataFrame(table).reset_index().melt("index")
        chi, f = (pg.friedman(frame, "value", "variable", "index", method=method) for method in ["chisq", "f"])
        rows.append({"rows": table.tolist(), "chi_square": float(found.statistic), "p": float(found.pvalue), "w": float(chi["W"].iloc[0]),
                     "f": float(f["F"].iloc[0])})
    return signed, two, rows


# Analysis of variance -----------------------------------------------------------------------------------------------

def helmert(length):
    contrasts = np.zeros((length, length - 1))
    for j in range(1, length):
        contrasts[:j, j - 1], contrasts[j, j - 1] = 1, -j
    return contrasts / np.linalg.norm(contrasts, axis=0)


def projected(values, lengths):
    """Every effect by projections on its Kronecker product of contrasts."""
    n = len(values)
    effects = {}
    for size in range(1, len(lengths) + 1):
        for factors in itertools.combinations(range(len(lengths)), size):
            matrix = np.ones((1, 1))
            for i, length in enumerate(lengths):
                matrix = np.kron(matrix, helmert(length) if i in factors else np.full((length, 1), length**-0.5))
            scores = values @ matrix
            d = matrix.shape[1]
            ss = n * float((scores.mean(0) ** 2).sum())
            error = float(((scores - scores.mean(0)) ** 2).sum())
            df_error = d * (n - 1)
            f = ss / d / (error / df_error)
            entry = {"ss": ss, "df": d, "ss_error": error, "df_error": df_error, "f": f, "p": float(stats.f.sf(f, d, df_error)),
                     "partial": ss / (ss + error),
                     "lambda": noncentralities(lambda f, lam: stats.ncf.cdf(f, d, df_error, lam) if lam else stats.f.cdf(f, d, df_error), f, 0, 50 + 10 * d * f)}
            if d > 1:
                s = np.cov(scores.T)
                gg = float(np.trace(s) ** 2 / (d * np.trace(s @ s)))
                entry["gg"], entry["p_gg"] = gg, float(stats.f.sf(f, gg * d, gg * df_error))
                if n - 1 - d * gg > 1e-9:
                    hf = (n * d * gg - 2) / (d * (n - 1 - d * gg))
                    entry["hf"], entry["p_hf"] = hf, float(stats.f.sf(f, min(hf, 1) * d, min(hf, 1) * df_error))
                if n > d:
                    sign, ln = np.linalg.slogdet(s)
                    ln_w = ln - d * np.log(np.trace(s) / d)
                    rho = 1 - (2 * d * d + d + 2) / (6 * d * (n - 1))
                    chi, df = -(n - 1) * rho * ln_w, d * (d + 1) // 2 - 1
                    second = (d + 2) * (d - 1) * (d - 2) * (2 * d**3 + 6 * d * d + 3 * d + 2) / (288 * ((n - 1) * d * rho) ** 2)
                    p, more = float(stats.chi2.sf(chi, df)), float(stats.chi2.sf(chi, df + 4))
                    entry.update(w=float(np.exp(ln_w)), chi_square=float(chi), p_w=p, p_w_second=p + second * (more - p))
            effects[":".join("ABC"[i] for i in factors)] = entry
    return effects


def long_format(values, lengths):
    rows = []
    for subject, row in enumerate(values):
        for value, cell in zip(row, itertools.product(*map(range, lengths))):
            rows.append({"subject": subject, "y": value, **{"ABC"[i]: f"{'abc'[i]}{level}" for i, level in enumerate(cell)}})
    return pd.DataFrame(rows)


def anovas():
    rng = np.random.Generator(np.random.PCG64(1959))
    sets = {"pingouin's rm_anova_wide": ([4], pg.read_dataset("rm_anova_wide").dropna().to_numpy())}
    for name, n, lengths in [("two levels", 8, [2]), ("five levels", 10, [5]), ("more contrasts than subjects", 6, [7]),
                             ("12 subjects, 3 × 4", 12, [3, 4]), ("9 subjects, 2 × 3", 9, [2, 3]), ("15 subjects, 4 × 4 × 3", 15, [4, 4, 3]),
                             ("20 subjects, 2 × 2 × 2", 20, [2, 2, 2]), ("13 subjects, 3 × 2 × 4", 13, [3, 2, 4])]:
        cells = int(np.prod(lengths))
        # Unequal variances and correlated neighbours, so that sphericity fails.
        mixing = rng.normal(0, 0.5, (cells, cells)) + np.diag(np.linspace(0.5, 2, cells))
        values = 50 + rng.normal(0, 4, (n, 1)) + rng.normal(0, 1, (n, cells)) @ mixing + rng.normal(0, 1.2, cells)
        sets[name] = (lengths, np.round(values, 3))
    result = []
    for name, (lengths, values) in sets.items():
        factors = list("ABC"[: len(lengths)])
        frame = long_format(values, lengths)
        effects = projected(values, lengths)
        total = float(((values - values.mean()) ** 2).sum())
        subjects = values.shape[1] * float(((values.mean(1) - values.mean()) ** 2).sum())
        errors = subjects + sum(effect["ss_error"] for effect in effects.values())
        # patsy, under statsmodels, takes a factor called C for its own function.
        renamed = frame.rename(columns={factor: f"of_{factor}" for factor in factors})
        statsmodels = {row.replace("of_", ""): {"f": float(at["F Value"]), "p": float(at["Pr > F"]), "df": float(at["Num DF"]), "df_error": float(at["Den DF"])}
                       for row, at in AnovaRM(renamed, "y", "subject", within=[f"of_{factor}" for factor in factors]).fit().anova_table.iterrows()}
        pingouin = {}
        if len(lengths) == 1:
            at = pg.rm_anova(frame, "y", "A", "subject", detailed=True, correction=True)
            at = {column: float(at[column].iloc[0]) for column in ["SS", "F", "ng2", "eps"] + (["W_spher"] if "W_spher" in at else [])}
            wide = frame.pivot(index="subject", columns="A", values="y")
            pingouin["A"] = {**at, "hf": float(pg.epsilon(wide, correction="hf"))}
        elif len(lengths) == 2:
            for _, at in pg.rm_anova(frame, "y", factors, "subject").iterrows():
                pingouin[at["Source"].replace(" * ", ":")] = {column: float(at[column]) for column in ["SS", "F", "ng2", "eps", "W_spher"] if np.isfinite(at[column])}
        result.append({"name": name, "lengths": lengths, "values": values.tolist(), "ss_total": total, "ss_subjects": subjects,
                       "projected": {key: {**effect, "generalised": effect["ss"] / (effect["ss"] + errors)} for key, effect in effects.items()},
                       "statsmodels": statsmodels, "pingouin": pingouin, "car": car(values, lengths)})
    return result


def car(values, lengths):
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
        pd.DataFrame(values).to_csv(file.name, index=False, header=False)
        done = subprocess.run(["Rscript", str(HERE / "statistics_peer.R"), file.name, *map(str, lengths)], capture_output=True, text=True, check=True)
    effects = {}
    for line in done.stdout.splitlines():
        name, *numbers = line.split(",")
        keys = ["ss", "df", "ss_error", "df_error", "f", "p", "gg", "p_gg", "hf", "p_hf", "w"]
        effects[name] = {key: float(number) for key, number in zip(keys, numbers) if number != "NA"}
    return effects


def main():
    warnings.simplefilter("ignore")
    tests, intervals = binomials()
    signed, two, rows = ranks()
    numbers = {"distributions": distributions(), "binomial_tests": tests, "binomial_intervals": intervals, "adjusted": adjusted(),
               "t_tests": t_tests(), "signed_ranks": signed, "mann_whitney": two, "friedman": rows, "anovas": anovas()}
    lines = [f"{json.dumps(key)}: [\n" + ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in entries) + "\n]" for key, entries in numbers.items()]
    OUT.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
