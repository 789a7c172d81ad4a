"""Psych-DS exports under the standard's rules, read with pandas, and under its own validator if that is at hand.

    PARAFOVEA_KEEP_EXPORTS=/tmp/kept cargo test --release -p stimuli -p parafovea --test exporting
    python psych_ds_peer.py /tmp/kept/psych-ds-ratings /tmp/kept/first-psych-ds [--validator "deno run -A src/index.ts"]

The rules are written here from the standard's text (Psych-DS 1.5.0), not from our check. --validator is a command that takes a
data set's folder: the validator's own repository, github.com/psych-ds/psychds-validator, is run by deno from its folder.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import pandas as pd

NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")


def rules(root):
    """Number of files, rows and variables; stops at the first rule that is broken."""
    description = json.loads((root / "dataset_description.json").read_text())
    assert description["@type"] == "Dataset" and description["@context"].rstrip("/") == "https://schema.org"
    assert description["name"] and description["description"]
    variables = [variable["name"] for variable in description["variableMeasured"]]
    assert len(set(variables)) == len(variables), "a variable is there twice"
    assert all(variable["description"] for variable in description["variableMeasured"])
    columns, rows, files = set(), 0, sorted((root / "data").rglob("*.csv"))
    assert files
    for path in files:
        assert NAME.fullmatch(path.name), path.name
        header = path.read_text().splitlines()[0].split(",")
        assert len(set(header)) == len(header), f"{path.name}: a column is there twice"
        table = pd.read_csv(path, low_memory=False)  # refuses rows that are too long
        assert list(table.columns) == header and table["row_id"].is_unique
        columns, rows = columns | set(header), rows + len(table)
    assert columns == set(variables), columns ^ set(variables)
    return len(files), rows, len(variables)


def accepted(command, root):
    run = subprocess.run([*command.split(), str(root.resolve())], capture_output=True, text=True)
    return "appears to be psych-DS compatible" in run.stdout + run.stderr


def main():
    arguments = sys.argv[1:]
    command = arguments.pop(arguments.index("--validator") + 1) if "--validator" in arguments else None
    roots = [pathlib.Path(name) for name in arguments if name != "--validator"]
    print(f"python {sys.version.split()[0]}, pandas {pd.__version__}")
    for root in roots:
        files, rows, variables = rules(root)
        said = "" if command is None else ", the validator accepts it" if accepted(command, root) else ", THE VALIDATOR REFUSES IT"
        print(f"{root.name}: {files} files, {rows} rows, {variables} variables, all rules held{said}")
        if "REFUSES" in said:
            sys.exit(1)
    if command:
        # A validator that accepts everything would say nothing.
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "copy"
            shutil.copytree(roots[0], copy)
            path = copy / "dataset_description.json"
            description = json.loads(path.read_text())
            description["variableMeasured"].pop()
            path.write_text(json.dumps(description))
            refused = not accepted(command, copy)
            print(f"without its last variable the validator {'refuses' if refused else 'ACCEPTS'} {roots[0].name}")
            sys.exit(not refused)


if __name__ == "__main__":
    main()
