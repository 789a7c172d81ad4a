"""CSV and Parquet exports read with pandas and pyarrow, and held against each other and against their dictionaries.

    PARAFOVEA_KEEP_EXPORTS=/tmp/kept cargo test --release -p stimuli -p parafovea --test exporting
    python tables_peer.py /tmp/kept/tables-csv /tmp/kept/tables-parquet

Checks that every file has the columns of columns.json in their order, that pandas reads numbers as numbers, that levels are the
ones described, that Parquet has the types the dictionary says and the dictionary itself in its metadata, and that both formats
hold the same values, bit for bit. Needs pandas, numpy and pyarrow.
"""

import json
import pathlib
import sys

import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet

TYPES = {"integer": "int64", "real": "double", "boolean": "bool", "text": "string"}


def main():
    csv, parquet = (pathlib.Path(name) for name in sys.argv[1:3])
    print(f"python {sys.version.split()[0]}, pandas {pd.__version__}, numpy {np.__version__}, pyarrow {pyarrow.__version__}")
    dictionary = json.loads((csv / "columns.json").read_text())
    total = units = places = 0
    for file, columns in dictionary.items():
        name = file.removesuffix(".csv")
        names = [column["name"] for column in columns]
        kinds = {column["name"]: column["type"] for column in columns}
        texts = {column: str for column, kind in kinds.items() if kind == "text"}
        table = pd.read_csv(csv / file, dtype=texts, na_values=[""], keep_default_na=False)
        assert list(table.columns) == names, f"{file}: columns"
        stored = pyarrow.parquet.ParquetFile(parquet / f"{name}.parquet")
        arrow = stored.read()
        assert arrow.column_names == names and arrow.num_rows == len(table), f"{name}: size"
        for column in columns:
            own, there = table[column["name"]], arrow[column["name"]]
            kind = column["type"]
            if kind != "text":
                assert pd.api.types.is_numeric_dtype(own) or own.isna().all(), f"{file}: {column['name']} is {own.dtype}"
            assert str(there.type) == TYPES[kind], f"{name}: {column['name']} is {there.type}"
            entry = json.loads(stored.schema_arrow.metadata[f"column:{column['name']}".encode()])
            assert entry == column, f"{name}: {column['name']}: metadata"
            for row, (left, right) in enumerate(zip(own, there.to_pylist())):
                same = pd.isna(left) if right is None else float(left) == float(right) if kind != "text" else left == right
                assert same, f"{name}: {column['name']}, row {row}: {left!r} and {right!r}"
            if "levels" in column:
                found = {str(int(value)) if kind != "text" else value for value in own.dropna()}
                assert found <= set(column["levels"]), f"{file}: {column['name']}: {found - set(column['levels'])}"
            units += bool(column["unit"])
            places += "reference" in column
        total += arrow.num_rows * arrow.num_columns
        print(f"  {name}: {arrow.num_rows} rows, {arrow.num_columns} columns")
    print(f"{len(dictionary)} tables, {total} cells the same in CSV and Parquet; {units} columns with units, {places} with a clock or axes")


if __name__ == "__main__":
    main()
