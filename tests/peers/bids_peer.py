"""BIDS exports under the official validator and pandas.

    PARAFOVEA_KEEP_EXPORTS=/tmp/kept cargo test --release -p stimuli -p parafovea --test exporting
    python bids_peer.py /tmp/kept/bids-* /tmp/kept/first-bids

Each data set must have no errors; its warnings are counted by code. Then every table is read with pandas: number of columns
against the description, numbers where numbers belong, onsets in order. Last, each of a few changes that break the standard is made
to a copy of the first data set, and it is printed which of them the validator lets pass: those our own check has to find
(src/export/bids/check/tests.rs makes the same). Needs pandas and bids-validator-deno.
"""

import collections
import gzip
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import pandas as pd


def validate(root):
    """Numbers of errors and warnings by code; nothing where the validator stops."""
    beside = pathlib.Path(sys.executable).with_name("bids-validator-deno")
    command = [str(beside) if beside.exists() else "bids-validator-deno", str(root), "--json"]
    run = subprocess.run(command, capture_output=True, text=True)
    try:
        issues = json.loads(run.stdout)["issues"]["issues"]
    except (ValueError, KeyError):
        return None
    counts = collections.defaultdict(collections.Counter)
    for issue in issues:
        counts[issue["severity"]][f"{issue['code']} {issue.get('subCode') or ''}".strip()] += 1
    return counts


def read(root):
    """Reads every table of a data set; returns how many files and rows."""
    files = rows = 0
    for path in sorted(root.rglob("*.tsv*")):
        name = str(path.relative_to(root))
        sidecar = json.loads(pathlib.Path(str(path).replace(".tsv.gz", ".json").replace(".tsv", ".json")).read_text())
        columns = sidecar.get("Columns")
        try:
            table = pd.read_csv(path, sep="\t", names=columns, header=None if columns else 0, na_values=["n/a"], keep_default_na=False, quoting=3)
        except pd.errors.EmptyDataError:
            sys.exit(f"{name}: nothing in it")
        for column in table.columns:
            assert column in sidecar, f"{name}: {column} is not described"
        for column in ("onset", "duration", "response_time", "timestamp", "x_coordinate", "y_coordinate", "pupil_size"):
            if column in table:
                assert pd.api.types.is_numeric_dtype(table[column]) or table[column].isna().all(), f"{name}: {column} is {table[column].dtype}"
        for column in ("onset", "timestamp"):
            if column in table:
                assert table[column].is_monotonic_increasing, f"{name}: {column} goes back"
        if "_physio." in name:
            width, height = json.loads(next(path.parent.glob("*_events.json")).read_text())["StimulusPresentation"]["ScreenResolution"]
            inside = table.x_coordinate.dropna().between(-width, 2 * width).all() and table.y_coordinate.dropna().between(-height, 2 * height).all()
            assert inside, f"{name}: places are far from the display"
        files, rows = files + 1, rows + len(table)
    return files, rows


def change(path, edit):
    value = json.loads(path.read_text())
    edit(value)
    path.write_text(json.dumps(value))


def breaks(root):
    """Changes that break the standard, by what they are."""
    one = lambda end: sorted(root.rglob(f"*{end}"))[0]
    screen = lambda key: change(one("_events.json"), lambda json: json["StimulusPresentation"].pop(key))
    def backwards():
        path = one("_physio.tsv.gz")
        lines = gzip.decompress(path.read_bytes()).splitlines(keepends=True)
        path.write_bytes(gzip.compress(b"".join(lines[::-1])))
    def without_recording():
        for path in sorted(root.rglob("*recording-eye1*")):
            path.rename(path.with_name(path.name.replace("_recording-eye1", "")))
    yield "no ScreenDistance", lambda: screen("ScreenDistance")
    yield "no ScreenSize", lambda: screen("ScreenSize")
    yield "no ScreenResolution", lambda: screen("ScreenResolution")
    yield "no ScreenOrigin", lambda: screen("ScreenOrigin")
    yield "no Units of x", lambda: change(one("_physio.json"), lambda json: json["x_coordinate"].pop("Units"))
    yield "no Units of y", lambda: change(one("_physio.json"), lambda json: json["y_coordinate"].pop("Units"))
    yield "no RecordedEye", lambda: change(one("_physio.json"), lambda json: json.pop("RecordedEye"))
    yield "no SamplingFrequency", lambda: change(one("_physio.json"), lambda json: json.pop("SamplingFrequency"))
    yield "no recording entity", without_recording
    yield "samples back in time", backwards
    yield "StartTime far from the first sample", lambda: change(one("_physio.json"), lambda json: json.update(StartTime=1e6))
    yield "OnsetSource of no column", lambda: change(one("_physioevents.json"), lambda json: json.update(OnsetSource="time"))
    yield "no events", lambda: [path.unlink() for path in root.rglob("*_events.*")]


def main():
    version = subprocess.run([sys.executable, "-m", "pip", "show", "bids-validator-deno"], capture_output=True, text=True).stdout
    version = next((line.split()[1] for line in version.splitlines() if line.startswith("Version")), "?")
    print(f"python {sys.version.split()[0]}, pandas {pd.__version__}, bids-validator-deno {version}")
    roots, failed, kinds = [pathlib.Path(name) for name in sys.argv[1:]], False, set()
    for root in roots:
        counts = validate(root)
        if counts is None:
            sys.exit(f"{root}: the validator stopped")
        files, rows = read(root)
        errors, warnings = sum(counts["error"].values()), sum(counts["warning"].values())
        failed |= errors > 0
        kinds |= set(counts["warning"])
        print(f"{root.name}: {errors} errors, {warnings} warnings; pandas read {files} tables, {rows} rows")
        for code, count in counts["error"].items():
            print(f"  error {code}: {count}")
    print("warnings: " + "; ".join(sorted(kinds)))
    passed = []
    with tempfile.TemporaryDirectory() as folder:
        names = [name for name, _ in breaks(roots[0])]
        for name in names:
            copy = pathlib.Path(folder) / "copy"
            shutil.copytree(roots[0], copy)
            dict(breaks(copy))[name]()
            counts = validate(copy)
            if counts is None:
                passed.append(f"{name} (it stops)")
            elif not counts["error"]:
                passed.append(name)
            shutil.rmtree(copy)
    print(f"of {len(names)} breaks the validator does not report {len(passed)}: " + "; ".join(passed))
    sys.exit(failed)


if __name__ == "__main__":
    main()
