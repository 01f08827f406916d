"""Files made to do harm: bombs that unpack, nest or repeat without end, and code in disguise."""

import io
import json
import pickle
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
from pyarrow import parquet
from safetensors.numpy import save

from rallygap.pipeline.io.schemas import STATE_COLUMNS

SENTINEL = Path("/tmp/rallygap-fuzz-code-ran")  # what hostile code would leave behind


class Trap:
    """What leaves the sentinel when it is unpickled."""

    def __reduce__(self):
        return SENTINEL.touch, ()


def _aliases(levels: int, step: str) -> str:
    lines = ["a0: &a0 [x, x]"]
    for k in range(1, levels):
        lines.append(f"a{k}: &a{k} {step.format(before=k - 1)}")
    return "\n".join(lines) + "\n"


def _merges(levels: int) -> str:
    lines = ["b0: &b0 {x: 1}"]
    for k in range(1, levels + 1):
        before = ", ".join([f"*b{k - 1}"] * 9)
        lines.append(f"b{k}: &b{k} {{<<: [{before}], y{k}: 1}}")
    return "\n".join(lines) + "\n"


def _packed(files: dict[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return packed.getvalue()


def _objects() -> bytes:
    """An npz whose array holds objects, which numpy unpickles if it is let."""
    packed = io.BytesIO()
    np.savez(packed, weight=np.array([Trap()], dtype=object))
    return packed.getvalue()


def _safetensors(header: object, data: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + data


def _one_array(kind: str, *shape: int) -> bytes:
    """Say of four bytes that they are an array."""
    return _safetensors(
        {"weight.0": {"dtype": kind, "shape": shape, "data_offsets": [0, 4]}}, b"0000"
    )


def _hdf5(shape: tuple[int, ...], kind: object = "f8", **settings: object) -> bytes:
    """A small file that says that it holds much."""
    made = io.BytesIO()
    with h5py.File(made, "w") as file:
        group = file.create_group("originals/0")
        group.create_dataset("time_stamps", shape[:1], kind, chunks=True, **settings)
        group.create_dataset("positions", shape, kind, chunks=True, **settings)
    return made.getvalue()


def _endless_hdf5() -> bytes:
    made = io.BytesIO()
    with h5py.File(made, "w") as file:
        file["originals/0"] = h5py.SoftLink("/originals/0")
        file["originals/1"] = h5py.ExternalLink("/etc/passwd", "/")
    return made.getvalue()


def _forecasts(rows: int, name: str, count: int = 0) -> bytes:
    """Forecasts whose windows all have one name, which stands in the file once."""
    names = pa.array([name]).dictionary_encode().dictionary
    columns = {"window_id": pa.DictionaryArray.from_arrays(np.zeros(rows, np.int32), names)}
    columns["horizon_ms"] = pa.array(np.full(rows, 100))
    columns |= {state: pa.array(np.zeros(rows)) for state in STATE_COLUMNS}
    columns |= {f"another_{k}": pa.array(np.zeros(rows)) for k in range(count)}
    made = io.BytesIO()
    parquet.write_table(pa.table(columns), made)
    return made.getvalue()


NOTHING_GOOD = [
    b"", b"\n", b"\x00" * 100, b"\xff\xfe", b"\xef\xbb\xbf", b"null", b"[]", b"{}", b"0", b'"text"',
    pickle.dumps(Trap()), _objects(), _packed({"weight.npy": b"\x00" * 50_000_000}),
    _packed({"archive/data.pkl": pickle.dumps(Trap())}),
]  # fmt: skip

JSON = [
    b"[" * 100_000, b'{"a":' * 100_000, b"[" + b"9" * 5000 + b"]", b'{"seed": 1e999}', b"[NaN]",
    b'{"a": 1, "a": 2}', b'"\\ud800"', b"[" + b"0," * 300_000 + b"0]",
    b'{"' + b"k" * 1_000_000 + b'": 1}',
]  # fmt: skip

YAML = [
    _aliases(40, "[*a{before}, *a{before}]").encode(),
    _aliases(9, "[" + ", ".join(["*a{before}"] * 9) + "]").encode(),
    _merges(9).encode(), b"a: &a [*a]", b"a: &a {b: *a}", b"drag: &d {cd: *d}",
    b"[" * 100_000, b"{a: " * 5000, b"- " * 5000, b"a:\n\t- b", b"%YAML 9.9", b"--- a\n--- b",
    b"seed: " + b"9" * 5000, f"!!python/object/apply:os.system ['touch {SENTINEL}']".encode(),
    b"seed: !!binary aGFsbG8=", b"? [a, b]\n: c", b"2026-99-99: 1", b"seed: 2026-01-01",
    b"a: !!set {b}", b'a: "\\ud800"', b"k: " + b"x" * 2_000_000,
]  # fmt: skip

SEPARATED = [
    b"t,x,y,z\n" + b",".join([b"1"] * 500_000), b"t,x,y,z\n" + b"0,0,0,0\n" * 20_000,
    b"t,x,y,z\n" + b"9" * 1_000_000 + b",0,0,0", b"t,x,y,z\n\"0\n\",0,0,0", b"t,x,y,z\n0,0,0,0\x00",
    b"t,x,y,z\n" + "٠,١,٢,٣\n１,２,３,４".encode(), b"t,x,y,z\n" + b"1e999,-1e999,nan,inf\n" * 50,
    b"\n".join(b"%d;0;0;0" % k for k in range(-50, 50)),
]  # fmt: skip

WEIGHTS = [
    (2**63).to_bytes(8, "little") + b"{}", (2**40).to_bytes(8, "little") + b"{}",
    _one_array("F32", 2**40, 2**40), _one_array("F32", -1), _one_array("BF16", 2),
    _one_array("F8_E4M3", 4), _one_array("O", 4),
    _safetensors({"weight.0": [1, 2]}), _safetensors([]), _safetensors({}), _safetensors({"": {}}),
    save({"weight.0": np.zeros((5, 0), np.float32), "bias.0": np.zeros(5, np.float32)}),
    save({"weight.0": np.zeros((), np.float32), "bias.0": np.zeros((), np.float32)}),
    save({"weight.0": np.zeros((5, 3), np.int64), "bias.0": np.zeros(5, np.int64)}),
    save({"weight.0": np.full((5, 3), np.nan, np.float32), "bias.0": np.zeros(5, np.float32)}),
]  # fmt: skip

PARQUET = [
    _forecasts(10_000_000, "x"), _forecasts(12, "x" * 5_000_000), _forecasts(24, "x" * 50_000_000),
    _forecasts(0, "x"), _forecasts(12, "\x00"), _forecasts(12, "x", count=3000),
]  # fmt: skip

HDF5 = [
    _hdf5((10**9, 3)), _hdf5((10**12, 3)), _hdf5((200_000_000, 3), compression="gzip"),
    _hdf5((3, 3), "S5"), _hdf5((3, 3), h5py.string_dtype()), _hdf5((0, 3)), _hdf5((3, 2)),
    _hdf5((3, 3), h5py.ref_dtype), _hdf5((3, 3), "c16"), _endless_hdf5(),
]  # fmt: skip
