"""Saccades, fixations and data quality by pymovements and ETDQualitizer, on a synthetic recording.

    pip install numpy==2.4.6 scipy==1.17.1 polars==2.1.0 pymovements==0.28.0 ETDQualitizer==1.2.0
    python gaze_peer.py --generate ../../analysis/tests/data/gaze_500hz.csv   (the recording and, beside it, its truth)
    python gaze_peer.py ../../analysis/tests/data/gaze_500hz.csv > ../../analysis/tests/data/gaze_peer.json

The recording: 500 Hz, 12 s, millidegrees right and up of the display's centre, an empty line where a sample is lost.
"""

import json
import sys

import ETDQualitizer as etdq
import numpy as np
import polars as pl
import pymovements as pm
from pymovements.measure.samples import measures as of_samples
from pymovements.events import ivt, microsaccades
from pymovements.events.detection.microsaccades import compute_threshold
from scipy import stats

RATE = 500.0


def progress(u):
    """Half a parabolic and half a minimum-jerk velocity profile: peak over mean 1.6875."""
    u = np.clip(u, 0.0, 1.0)
    return 0.5 * u * u * (3 - 2 * u) + 0.5 * u**3 * (10 + u * (6 * u - 15))


def generate(path):
    """Fixations with drift, noise and microsaccades between saccades of known time and size, one blink, lost samples."""
    rng = np.random.Generator(np.random.PCG64(20030000))
    t = np.arange(6000) / RATE
    eye = np.zeros((len(t), 2))
    truth = []
    onset = 0.35
    place = np.zeros(2)
    while onset < 11.6:
        micro = rng.random() < 0.45
        size = rng.uniform(0.25, 0.6) if micro else np.exp(rng.uniform(np.log(1.0), np.log(9.0)))
        angle = rng.uniform(0, 2 * np.pi)
        way = size * np.array([np.cos(angle), np.sin(angle)])
        # Stay within 8 degrees of the centre.
        if np.linalg.norm(place + way) > 8:
            way = -size * place / np.linalg.norm(place)
        duration = 0.021 + 0.0022 * size
        eye += progress((t - onset) / duration)[:, None] * way
        truth.append([round(onset, 6), round(duration, 6), round(float(way[0]), 6), round(float(way[1]), 6)])
        place = place + way
        onset += rng.uniform(0.22, 0.5)
    drift = np.cumsum(rng.normal(0, 0.0015, eye.shape), axis=0)
    recorded = eye + drift + rng.normal(0, 0.008, eye.shape)
    lost = np.zeros(len(t), bool)
    lost[2700:2775] = True
    lost[[811, 1502, 3333, 3334, 4810, 5444]] = True
    milli = np.round(1000 * recorded).astype(int)
    with open(path, "w") as file:
        for (x, y), gone in zip(milli, lost):
            file.write("\n" if gone else f"{x},{y}\n")
    with open(path.replace(".csv", "_truth.csv"), "w") as file:
        file.write("onset_s,duration_s,right_deg,up_deg\n")
        file.writelines(",".join(map(str, row)) + "\n" for row in truth)


def read(path):
    rows = []
    for line in open(path):
        line = line.strip()
        rows.append([np.nan, np.nan] if not line else [float(v) / 1000 for v in line.split(",")])
    return np.array(rows)


def velocities(position, method):
    gaze = pm.gaze.from_numpy(position=position.T, time=np.arange(len(position)) * 2,
                              experiment=pm.Experiment(sampling_rate=RATE))
    gaze.pos2vel(method)
    values = gaze.samples["velocity"]
    as_float = lambda v: np.nan if v is None else v
    return np.array([[as_float(v[0]), as_float(v[1])] if v is not None else [np.nan, np.nan] for v in values.to_list()])


def boundaries(events):
    return [[int(a), int(b)] for a, b in zip(events.frame["onset"], events.frame["offset"])]


def measures(position, velocity, spans):
    """Amplitude and peak velocity of pymovements' measures, over the samples of each event."""
    found = []
    for onset, offset in spans:
        part = slice(onset // 2, offset // 2 + 1)
        frame = pl.DataFrame({"position": position[part].tolist(), "velocity": velocity[part].tolist()})
        row = frame.select(
            of_samples.amplitude().alias("amplitude"), of_samples.peak_velocity().alias("peak_velocity"),
            of_samples.dispersion().alias("dispersion"))
        found.append([round(float(row[name][0]), 6) for name in ("amplitude", "peak_velocity", "dispersion")])
    return found


def fick(deg):
    """Azimuth and elevation of places whose coordinates are each axis's own angle on a flat display."""
    x, y = np.tan(np.radians(deg[:, 0])), np.tan(np.radians(deg[:, 1]))
    return np.degrees(np.arctan(x)), np.degrees(np.arctan2(y, np.hypot(x, 1)))


def quality(position, target):
    azi, ele = fick(position)
    t_azi, t_ele = fick(np.array([target]))
    accuracy = etdq.accuracy(azi, ele, t_azi[0], t_ele[0])
    seen = ~np.isnan(azi)
    area, orientation, *_ = etdq.bcea(azi[seen], ele[seen], 0.6827)
    area_95 = etdq.bcea(azi[seen], ele[seen], 0.95)[0]
    return {
        "offset_deg": accuracy[0],
        "rms_s2s_deg": etdq.rms_s2s(azi, ele)[0],
        "sd_deg": etdq.std(azi, ele)[0],
        "sd_axes_deg": list(etdq.std(azi, ele)[1:]),
        "bcea_68_deg2": area,
        "bcea_95_deg2": area_95,
        "orientation_deg": (orientation + 90) % 180 - 90,
        "invalid_percent": float(etdq.data_loss_from_invalid(azi, ele)),
        "missing_percent": float(etdq.data_loss_from_expected(azi, ele, len(azi) / RATE, RATE)),
        "effective_hz": float(etdq.effective_frequency(azi, ele, len(azi) / RATE)),
    }


def main_sequence():
    """A power law through eight invented saccades, by scipy's linregress."""
    a = np.array([0.4, 0.8, 1.5, 3.0, 5.0, 8.0, 12.0, 20.0])
    v = np.array([31.0, 52.0, 95.0, 148.0, 212.0, 281.0, 350.0, 402.0])
    line = stats.linregress(np.log(a), np.log(v))
    t = stats.t.ppf(0.975, len(a) - 2)
    return {
        "exponent": line.slope, "exponent_ci95": [line.slope - t * line.stderr, line.slope + t * line.stderr],
        "k": np.exp(line.intercept),
        "k_ci95": list(np.exp([line.intercept - t * line.intercept_stderr, line.intercept + t * line.intercept_stderr])),
        "r2": line.rvalue**2,
    }


def compute(path):
    position = read(path)
    times = np.arange(len(position)) * 2  # ms
    by_neighbours, by_five = velocities(position, "neighbors"), velocities(position, "fivepoint")
    fixations = boundaries(ivt(by_neighbours, timesteps=times, minimum_duration=60, velocity_threshold=30.0))
    result = {"ivt": {"fixations_ms": fixations, "measures": measures(position, by_neighbours, fixations)}}
    for method in ("engbert2003", "engbert2015"):
        threshold = compute_threshold(by_five, method)
        saccades = boundaries(microsaccades(by_five, timesteps=times, minimum_duration=6, threshold=method))
        result[method] = {"sd_deg_s": [float(v) for v in threshold], "saccades_ms": saccades,
                          "measures": measures(position, by_five, saccades)}
    # Two stretches without events, one at rest near the centre and one with lost samples, and one drawn to the side.
    rng = np.random.Generator(np.random.PCG64(2020))
    centred = rng.multivariate_normal([0.3, -0.2], [[0.01, 0.004], [0.004, 0.02]], 200).round(4)
    centred[[20, 21, 90]] = np.nan
    aside = rng.multivariate_normal([14.6, 8.1], [[0.02, -0.006], [-0.006, 0.01]], 200).round(4)
    result["quality"] = [
        {"target_deg": target, "position_mdeg": [None if np.isnan(p[0]) else [round(1e4 * v) / 10 for v in p] for p in data],
         **quality(data, target)}
        for data, target in ((centred, [0.0, 0.0]), (aside, [14.0, 8.0]))
    ]
    result["main_sequence"] = main_sequence()
    print(json.dumps(result, separators=(",", ":")))


if __name__ == "__main__":
    generate(sys.argv[2]) if sys.argv[1] == "--generate" else compute(sys.argv[1])
