"""Random alterations of bytes, plain data, arrays and HDF5 files, each described in words."""

import copy
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e38, 1e30, 1e13, -1e13, 1e7, 0.0, -1.0, 1e-30)


def alter_bytes(path: Path, random: np.random.Generator) -> str:
    """Damage: some bytes changed, or the end lost."""
    data = bytearray(path.read_bytes())
    at = int(random.integers(len(data)))
    if random.random() < 0.3:
        path.write_bytes(data[:at])
        return f"bytes from {at} on lost"
    data[at] ^= int(random.integers(1, 256))
    path.write_bytes(data)
    return f"byte {at} changed"


def alter_plain(plain, random: np.random.Generator) -> str:
    """Alter one entry of plain data in place; returns what was done."""
    nodes = list(_nodes(plain))
    holder, key = nodes[int(random.integers(len(nodes)))]
    deep: list = []
    for _ in range(500):
        deep = [deep]
    value = holder[key]
    values = [None, "", "text", "../../x", -1, 0, 1, 2.5, 10**30, 10**400, 1e308, float("nan"), float("inf"), True]
    values += [[], {}, [value], {"a": value}, deep, "x" * 200_000, [value] * 3, [0] * 5000]
    if isinstance(value, int | float) and not isinstance(value, bool):
        values += [value + 1, -value, value * 10, value * 1e6, str(value)] * 2
    if isinstance(value, list):
        values += [value[:-1], value + value[-1:], value[::-1], [str(one) for one in value]] * 2
    choice = int(random.integers(len(values) + 4))
    if choice >= len(values) and isinstance(holder, dict):
        if choice % 2:
            del holder[key]
            return f"{key} deleted"
        holder[f"{key}2"] = value
        return f"{key}2 added"
    holder[key] = new = copy.copy(values[choice % len(values)])
    return f"{key} = {new!r:.60}"


def _nodes(plain) -> Iterator[tuple]:
    keys = list(plain) if isinstance(plain, dict) else range(min(len(plain), 20))
    for key in keys:
        yield plain, key
        if isinstance(plain[key], dict | list):
            yield from _nodes(plain[key])


def alter_arrays(arrays: dict, random: np.random.Generator) -> str:
    """Alter one of some arrays in place; returns what was done."""
    name = str(random.choice(sorted(arrays)))
    values = arrays[name]
    kind = str(random.choice(["value", "scale", "type", "shape", "rows", "name", "order", "noise"]))
    if kind == "value":
        number = NUMBERS[int(random.integers(len(NUMBERS)))]
        arrays[name] = changed = np.array(values, copy=True)
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            new = (
                np.float64(number) if changed.dtype.kind == "f" else random.choice([-1, 2**31 - 1, 10**9, -(2**31), 7])
            )
            if changed.size:
                changed.reshape(-1)[int(random.integers(changed.size))] = np.asarray(new).astype(changed.dtype)
            if random.random() < 0.2:
                changed[...] = np.asarray(new).astype(changed.dtype)
        return f"{name}: a value {number}"
    if kind == "scale":
        factor = float(random.choice([0.0, -1.0, 10.0, 1e4, 1e9, 1e20, 1e35, 1e-20]))
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            arrays[name] = (values * factor).astype(values.dtype)
        return f"{name} times {factor:g}"
    if kind == "type":
        wanted = random.choice(["float16", "float32", "float64", "int8", "int64", "uint8", "uint64", "bool"])
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            arrays[name] = values.astype(wanted)
        return f"{name} as {wanted}"
    if kind == "shape":
        shapes = [values.T, values.reshape(-1), values[None], values[..., None], np.zeros((0, *values.shape[1:]))]
        arrays[name] = new = shapes[int(random.integers(len(shapes)))].astype(values.dtype)
        return f"{name} in the shape {new.shape}"
    if kind == "rows" and values.ndim and len(values):
        new = [values[:-1], values[:1], np.concatenate([values, values[-1:]]), np.repeat(values, 3, axis=0)]
        new += [values[..., :-1], np.concatenate([values, values[..., -1:]], axis=-1)]
        arrays[name] = one = new[int(random.integers(len(new)))]
        return f"{name} with {one.shape} rows"
    if kind == "name":
        other = str(random.choice([*sorted(arrays), "more", "weights.more", "blocks.0.x", ""]))
        arrays[other] = arrays.pop(name) if random.random() < 0.7 else values
        return f"{name} named {other}"
    if kind == "order" and values.ndim:
        arrays[name] = random.permutation(values, axis=int(random.integers(values.ndim)))
        return f"{name} in another order"
    if values.dtype.kind == "f":
        spread = np.abs(values).max(initial=0) * 10.0 ** random.integers(-2, 3)
        with np.errstate(all="ignore"):
            arrays[name] = (values + spread * random.normal(size=values.shape)).astype(values.dtype)
        return f"{name} with noise"
    del arrays[name]
    return f"{name} deleted"


def alter_background(path: Path, content: Mapping, random: np.random.Generator) -> str:
    """Write an altered background as anyone can write HDF5; returns what was done."""
    import h5py

    recording = str(random.choice(sorted(content)))
    arrays, attributes = content[recording]
    kind = str(random.choice(["array", "attribute", "link", "group", "type", "sparse", "outside", "jpeg", "recording"]))
    said = ""
    if kind == "array":
        said = alter_arrays(arrays, random)
    elif kind == "attribute":
        said = alter_plain(attributes, random)
    elif kind == "jpeg":
        first = int(random.integers(arrays["ends"][0]))
        arrays["pictures"] = arrays["pictures"].copy()
        arrays["pictures"][first : first + 8] = random.integers(0, 256, len(arrays["pictures"][first : first + 8]))
        said = f"bytes of the first JPEG from {first} on"
    elif kind == "recording":
        del content[recording]
        said = f"{recording} deleted"
        if random.random() < 0.5:
            content.clear()
            said = "no recording"
    name = str(random.choice(sorted(arrays)))
    with h5py.File(path, "w") as file:
        for one, (own, tags) in content.items():
            group = file.create_group(one)
            for key, value in own.items():
                if key:
                    group.create_dataset(key, data=value)
            for key, value in tags.items():
                try:
                    group.attrs[key] = value
                except Exception:  # what HDF5 cannot hold is no case
                    group.attrs[key] = str(value)[:1000]
        if kind in ("array", "attribute", "jpeg", "recording"):
            return said
        group = file[recording]
        old = group[name][()]
        del group[name]
        if kind == "link":
            links = [h5py.SoftLink(f"/{recording}/ends"), h5py.SoftLink("/nowhere"), h5py.SoftLink(f"/{recording}")]
            links += [h5py.ExternalLink("/etc/passwd", "/"), h5py.ExternalLink(str(path.parent / "x.h5"), "/x")]
            group[name] = links[int(random.integers(len(links)))]
        elif kind == "group":
            group.create_group(name)
        elif kind == "type":
            texts = h5py.string_dtype()
            kinds = [np.array([b"ab"]), np.array([(1, 2.0)], "i4,f8"), np.zeros(3, complex)]
            if random.random() < 0.3:
                group.create_dataset(name, data=["a", "b"], dtype=texts)
            elif random.random() < 0.3:
                group.create_dataset(name, data=h5py.Empty("f"))
            else:
                group.create_dataset(name, data=kinds[int(random.integers(3))])
        elif kind == "sparse":
            size = (int(10 ** random.integers(6, 15)), *old.shape[1:])
            group.create_dataset(name, shape=size, dtype=old.dtype, chunks=(1000, *old.shape[1:]), compression="gzip")
        elif random.random() < 0.5:
            outside = [(str(path.parent / "speaker.json"), 0, old.nbytes)]
            group.create_dataset(name, shape=old.shape, dtype=old.dtype, external=outside)
        else:
            layout = h5py.VirtualLayout(old.shape, old.dtype)
            layout[...] = h5py.VirtualSource(str(path.parent / "other.h5"), "x", old.shape)
            group.create_virtual_dataset(name, layout)
    return f"{recording}/{name}: {kind}"
