"""Reads a Parquet file of results and compares it with the CSV file cell by cell.

usage: sweep_in_parquet.py FILE.csv FILE.parquet PLAN.toml KEY=TYPE...
"""

import csv
import sys
from pathlib import Path

import pyarrow.parquet as pq

FIXED = {
    "seed": "int64",
    "outcome": "string",
    "passed": "bool",
    "state": "string",
    "rings": "bool",
    "simulated_s": "double",
    "tracking.rms_m": "double",
    "tracking.max_m": "double",
    "tracking.final_m": "double",
    "tracking.final_heading_rad": "double",
    "tracking.max_after_30s_m": "double",
    "tracking.travelled_m": "double",
    "torque.max_nm": "double",
    "torque.chatter_nm": "double",
    "bus.frames": "int64",
    "bus.lost": "int64",
    "bus.error_frames": "int64",
    "bus.load_percent": "double",
    "frames_blake3": "string",
    "error": "string",
}
READ = {"int64": int, "double": float, "bool": {"true": True, "false": False}.get, "string": str}

csv_path, parquet_path, plan_path = map(Path, sys.argv[1:4])
keys = dict(pair.rsplit("=", 1) for pair in sys.argv[4:])
types = {"run": "int64", **keys, **FIXED}
with open(csv_path, newline="") as file:
    header, *lines = csv.reader(file)

parquet = pq.ParquetFile(parquet_path)
schema = parquet.schema_arrow
assert schema.names == header == list(types), (schema.names, header)
assert {field.name: str(field.type) for field in schema} == types, schema
never_empty = {"run", "seed", "outcome", *keys}
assert {field.name for field in schema if not field.nullable} == never_empty, schema
told = {key.decode(): value.decode() for key, value in parquet.metadata.metadata.items()}
assert (told["plan"], told["program"]) == (plan_path.read_text(), "hil-sim"), told
assert told["version"].count(".") == 2, told
for number in range(parquet.num_row_groups):
    group = parquet.metadata.row_group(number)
    assert [(column.column_index, column.descending) for column in group.sorting_columns] == [(0, False)]
    assert {group.column(nth).compression for nth in range(group.num_columns)} == {"ZSTD"}


def expected(name, cell):
    return None if cell == "" and name not in never_empty else READ[types[name]](cell)


rows = parquet.read().to_pylist()
assert rows == [{name: expected(name, cell) for name, cell in zip(header, line)} for line in lines]
assert rows == sorted(rows, key=lambda row: row["run"])
# A column is found by its name although that has a point in it.
[column] = pq.read_table(parquet_path, columns=["tracking.rms_m"]).columns
assert column.to_pylist() == [row["tracking.rms_m"] for row in rows]

refused = [row for row in rows if row["outcome"] == "refused"]
for row in refused:
    filled = {name for name, value in row.items() if value is not None}
    assert filled == never_empty | {"error"}, row
assert all(row["error"] is None and row["passed"] is not None for row in rows if row not in refused)
print(f"{len(rows)} rows, {len(refused)} refused")
