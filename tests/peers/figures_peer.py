"""Numbers behind figures: the five numbers of a box plot by matplotlib, within-subject intervals by numpy and scipy."""

import numpy as np
from matplotlib.cbook import boxplot_stats
from scipy import stats

values = [2.1, 3.4, 3.9, 4.4, 4.6, 5.0, 5.3, 5.9, 6.2, 7.7, 12.5, -4.0]
box = boxplot_stats(values)[0]
for key in ["q1", "med", "q3", "whislo", "whishi", "mean", "cilo", "cihi"]:
    print(f"{key} {float(box[key]):.15g}")
print("fliers", [float(v) for v in box["fliers"]])

# Cousineau (2005) with Morey's correction (2008): rows are observers, columns conditions.
y = np.array([[3.0, 4.5, 5.0], [1.0, 2.0, 4.5], [4.0, 4.0, 6.5], [2.5, 3.5, 3.0], [5.0, 7.0, 7.5]])
n, conditions = y.shape
normalised = y - y.mean(axis=1, keepdims=True) + y.mean()
sd = np.sqrt(normalised.var(axis=0, ddof=1) * conditions / (conditions - 1))
half = stats.t.ppf(0.975, n - 1) * sd / np.sqrt(n)
print("means", y.mean(axis=0).tolist())
print("half", [f"{h:.15g}" for h in half])
