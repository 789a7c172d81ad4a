"""Fits by psignifit 4.3, for analysis/tests/psignifit.rs, which includes the file that this writes.

    python psignifit_peer.py > ../../analysis/tests/psignifit_4_3.json

Every fit has its data, mode, means, 95 % intervals, and the step of the grid at each parameter (the intervals are known to sit
half a step low). A Weibull function's thresholds are natural logarithms of levels.
"""

import json
import sys

import numpy as np
import psignifit as ps
import scipy

EVEN = [1, 2, 3, 4, 5, 6, 7]
OCTAVES = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6]

DATA = {
    "readings": (EVEN, [40] * 7, [19, 22, 27, 32, 37, 39, 39]),
    "few": (EVEN, [10] * 7, [4, 6, 5, 7, 9, 10, 10]),
    "spread": ([0.5, 1.0, 2.5, 3.0, 4.5, 7.0], [24, 30, 50, 50, 28, 16], [1, 3, 15, 24, 25, 15]),
    "drifting": (EVEN, [60] * 7, [6, 4, 23, 20, 47, 41, 60]),
    "octaves": (OCTAVES, [30] * 6, [14, 16, 17, 24, 29, 30]),
    "three": (EVEN, [36] * 7, [11, 14, 17, 25, 31, 35, 35]),
}

FITS = [
    ("readings", "norm", "2AFC", None),
    ("readings", "logistic", "2AFC", None),
    ("readings", "gumbel", "2AFC", None),
    ("readings", "rgumbel", "2AFC", None),
    ("readings", "tdist", "2AFC", None),
    ("few", "norm", "2AFC", None),
    ("few", "logistic", "2AFC", None),
    ("spread", "norm", "yes/no", None),
    ("spread", "logistic", "yes/no", None),
    ("spread", "gumbel", "yes/no", None),
    ("drifting", "norm", "yes/no", None),
    ("drifting", "rgumbel", "yes/no", None),
    ("octaves", "weibull", "2AFC", None),
    ("three", "norm", "3AFC", 3),
    ("three", "gumbel", "3AFC", 3),
]


def main():
    fits = []
    for data, sigmoid, experiment, choices in FITS:
        levels, n, k = DATA[data]
        # psignifit's Weibull function is a Gumbel one, and leaves taking logarithms to its user.
        logarithmic = sigmoid == "weibull"
        table = np.array([np.log(levels) if logarithmic else levels, k, n], float).T
        options = {"experiment_type": "nAFC", "experiment_choices": choices} if choices else {"experiment_type": experiment}
        result = ps.psignifit(table, sigmoid=sigmoid, verbose=False, **options)
        steps = {}
        for name, values in result.parameter_values.items():
            values = np.atleast_1d(values)
            steps[name] = float(values[1] - values[0]) if len(values) > 1 else 0.0
        fits.append(
            {
                "data": data,
                "sigmoid": sigmoid,
                "experiment": experiment,
                "levels": levels,
                "n": n,
                "k": k,
                "map": result.parameter_estimate_MAP,
                "mean": result.parameter_estimate_mean,
                "ci95": {name: intervals["0.95"] for name, intervals in result.confidence_intervals.items()},
                "step": steps,
            }
        )
        print(data, sigmoid, experiment, result.parameter_estimate_MAP, file=sys.stderr)
    origin = f"psignifit {ps.__version__ if hasattr(ps, '__version__') else '4.3'}, numpy {np.__version__}, scipy {scipy.__version__}"
    print(json.dumps({"origin": origin, "fits": fits}, indent=1))


if __name__ == "__main__":
    main()
