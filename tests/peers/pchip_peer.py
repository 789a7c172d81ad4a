"""Monotone cubic interpolation by scipy: the numbers that experiments/src/contrast/peer_numbers.in holds.

    python pchip_peer.py > ../../experiments/src/contrast/peer_numbers.in
"""

import numpy
import scipy
from scipy.interpolate import PchipInterpolator


def table(name, rows, about):
    print(f"/// {about}")
    print(f"const {name}: [(f64, f64); {len(rows)}] = [")
    for x, y in rows:
        print(f"    ({float(x)!r}, {float(y)!r}),")
    print("];")


print(f"// Written by tests/peers/pchip_peer.py with scipy {scipy.__version__}, numpy {numpy.__version__}.")
print()
# Rising, falling, flat and steep pieces, unevenly spaced, so that every rule for a slope is used, at the ends too.
knots = [(0.0, 1.0), (1.0, 3.0), (2.5, 2.0), (3.0, 2.0), (5.0, 9.0), (5.5, 9.5), (8.0, -4.0)]
curve = PchipInterpolator(*zip(*knots))
table("SCIPY_KNOTS", knots, "Points of a curve.")
print()
at = [0.1, 0.5, 0.9, 1.3, 2.0, 2.4, 2.7, 3.1, 4.0, 4.9, 5.2, 5.49, 6.0, 7.0, 7.9]
table("SCIPY_PCHIP", [(x, curve(x)) for x in at], "The curve between its points, by `PchipInterpolator`.")
print()
# The full-resolution calibration of Tursun 2019: log10 sensitivities at 4, 8, 16, 32 cpd, flat below 4, 1e-32 at 64; in ln over ln.
log10 = [6.2985, 6.2985, 5.5486, 7.4847, 7.9453, -32.0]
csf = PchipInterpolator(numpy.log([1e-32, 4, 8, 16, 32, 64]), numpy.array(log10) * numpy.log(10))
cpd = [0.5, 4.0, 4.5, 6.0, 7.9, 9.0, 12.0, 15.5, 20.0, 24.9, 31.0, 33.0, 40.0, 60.0]
table("SCIPY_LN_SENSITIVITY", [(f, csf(numpy.log(f))) for f in cpd], "ln S' at frequencies in cpd, by the same.")
