"""Damage done to inputs: to bytes, and to the trees, tables and arrays that they stand for.

Bytes at random are refused by the first parser that sees them. What is wrong in one place only
gets further, so text is parsed, changed in one place or a few, and written again.
"""

from __future__ import annotations

import copy
import io
import json
import struct
import tomllib
import zipfile
from collections.abc import Callable, Sequence
from random import Random
from typing import Any, TypeAlias

import numpy as np

from kinolab.scenario.toml_text import key_text, value_text

Mutator: TypeAlias = Callable[[bytes, Random], bytes]

MOST = 60_000  # [bytes] to which an input may grow; larger ones are made on purpose, elsewhere
NUMBERS = (
    *(0, -1, 1, 2, 7, 255, 256, 65_536, 2**31 - 1, 2**31, 2**32, 2**63 - 1, 2**63, 2**64, -(2**63)),
    *(0.5, -0.0, 1e-300, 5e-324, 1e308, -1e308, 1e-9, 3.141592653589793, 10**30, 10**400),
)
NOT_FINITE = (float("inf"), float("-inf"), float("nan"))
WORDS = (
    *("", " ", "x", "nan", "inf", "-0", "\x00", "\n", "é", "∞", "\u202e", "𝔛", "a" * 300, "1e999"),
    *("../x", "/dev/zero", "a.b", "a=b", '"', "'", "pi/2", "90 deg", "pi", "1" + " " * 40 + "x"),
    *("__class__", "self", "name", "true", "[1]", "{}", "%s", "<script>", "٣", "1_0", "0x10"),
)
TOKENS = (
    *(b"\x00", b"\xff", b"\n", b"\r\n", b" ", b"\t", b"=", b"[", b"]", b"{", b"}", b'"', b"'"),
    *(b",", b":", b".", b"-", b"#", b"nan", b"inf", b"1e999", b"-1", b"0", b"9" * 20, b"true"),
    *(b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\\ud800", b"'''", b'"""', b"[[", b"]]", b"<", b">", b"/"),
    *(struct.pack("<I", n) for n in (0, 1, 2**31, 2**32 - 1)),
    *(struct.pack("<d", n) for n in (0.0, float("nan"), float("inf"), 1e308)),
)


def of_bytes(*tokens: bytes) -> Mutator:
    """Return a mutator of bytes that inserts these tokens, too."""
    known = TOKENS + tokens

    def mutate(data: bytes, random: Random) -> bytes:
        content = bytearray(data)
        for _ in range(random.choice((1, 1, 2, 4, 8))):
            _change_bytes(content, random, known)
        return bytes(content[:MOST])

    return mutate


def _change_bytes(content: bytearray, random: Random, tokens: Sequence[bytes]) -> None:
    at = random.randrange(len(content) + 1)
    length = random.choice((1, 1, 2, 4, 8, 64, 500))
    match random.randrange(8):
        case 0 if content:
            content[at % len(content)] ^= 1 << random.randrange(8)
        case 1 if content:
            content[at % len(content)] = random.randrange(256)
        case 2:
            del content[at : at + length]
        case 3:
            piece = content[at : at + length]
            to = random.randrange(len(content) + 1)
            content[to:to] = piece * random.choice((1, 1, 2, 50))
        case 4:
            token = random.choice(tokens)
            content[at : at + random.choice((0, len(token)))] = token
        case 5:
            content[at:at] = random.choice(tokens) * random.choice((1, 1, 3, 200))
        case 6:
            lines = bytes(content).split(b"\n")
            random.shuffle(lines) if random.random() < 0.2 else lines.pop(
                random.randrange(len(lines))
            )
            content[:] = b"\n".join(lines)
        case _:
            content[at:at] = random.randbytes(length)


# --- trees: tables, lists and values, as TOML and JSON have them ---


def of_toml(*words: str) -> Mutator:
    """Return a mutator of TOML, that writes these words, too."""
    return _of_tree(_toml_read, _toml_text, words, finite=False)


def of_json(*words: str) -> Mutator:
    """Return a mutator of JSON, that writes these words, too."""
    return _of_tree(json.loads, _json_text, words, finite=False)


SIZES = (0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 3.0, 100.0, 1e4, 1e6, 1e9, 1e15, 1e300)


def of_numbers(data: bytes, random: Random) -> bytes:
    """Replace a few numbers of a TOML file by others of their kind."""
    try:
        tree = _toml_read(data)
    except (ValueError, RecursionError):
        return of_bytes()(data, random)
    places = [(h, k) for h, k in _places(tree) if type(h[k]) in (int, float) and k != "schema"]
    for holder, key in random.sample(places, min(len(places), random.choice((1, 1, 2, 3)))):
        size = random.choice(SIZES) * random.choice((1, 1, 1, -1, random.uniform(0.5, 2)))
        holder[key] = int(size) if isinstance(holder[key], int) else size
    return _toml_text(tree, random)


def _of_tree(
    read: Callable[[bytes], Any],
    write: Callable[[Any, Random], bytes],
    words: Sequence[str],
    *,
    finite: bool,
) -> Mutator:
    raw = of_bytes(*(word.encode() for word in words))

    def mutate(data: bytes, random: Random) -> bytes:
        if random.random() < 0.15:
            return raw(data, random)
        try:
            tree = read(data)
        except (ValueError, RecursionError):
            return raw(data, random)
        try:
            for _ in range(random.choice((1, 1, 1, 2, 3, 6))):
                tree = _changed(tree, random, words, finite=finite)
            return write(tree, random)[:MOST]
        except (ValueError, RecursionError):
            return raw(data, random)

    return mutate


def _toml_read(data: bytes) -> Any:
    return tomllib.loads(data.decode())


def _toml_text(tree: Any, _: Random) -> bytes:
    if not isinstance(tree, dict):
        tree = {"value": tree}
    text = "\n".join(f"{key_text(str(key))} = {value_text(value)}" for key, value in tree.items())
    return text.encode(errors="replace")


def _json_text(tree: Any, random: Random) -> bytes:
    return json.dumps(tree, ensure_ascii=random.random() < 0.5).encode(errors="replace")


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Return every table or list with each of its keys or indices."""
    found, left = [], [tree]
    while left:
        holder = left.pop()
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        for key in keys:
            found.append((holder, key))
            if isinstance(holder[key], dict | list):
                left.append(holder[key])
    return found


def _changed(tree: Any, random: Random, words: Sequence[str], *, finite: bool) -> Any:
    places = _places(tree) if isinstance(tree, dict | list) else []
    if not places or random.random() < 0.01:
        return _value(random, words, finite=finite)
    holder, key = random.choice(places)
    other, at = random.choice(places)
    match random.randrange(10):
        case 0:
            del holder[key]
        case 1:
            holder[key] = copy.deepcopy(other[at])
        case 2 if isinstance(holder, dict):
            name = random.choice((*words, *WORDS, *map(str, holder)))
            holder[name] = holder.pop(key)
        case 3:
            holder[key] = [copy.deepcopy(holder[key]) for _ in range(random.choice((0, 1, 2, 9)))]
        case 4:
            deep = copy.deepcopy(holder[key])
            for _ in range(random.choice((1, 2, 5, 70, 300))):
                deep = [deep] if random.random() < 0.5 else {"a": deep}
            holder[key] = deep
        case 5 if isinstance(holder, list):
            holder.insert(key, copy.deepcopy(other[at]))
        case 6 if isinstance(holder, dict):
            name = random.choice((*words, *WORDS))
            holder[name] = _value(random, words, finite=finite)
        case 7 if isinstance(holder[key], int | float) and not isinstance(holder[key], bool):
            factor = random.choice((-1, 0, 2, 10, 1e-3, 1e6, 1e30, 1.0000001))
            try:
                holder[key] = holder[key] * factor
            except OverflowError:
                holder[key] = 0
        case _:
            holder[key] = _value(random, words, finite=finite)
    return tree


def _value(random: Random, words: Sequence[str], *, finite: bool) -> Any:
    match random.randrange(8):
        case 0 | 1:
            return random.choice(NUMBERS)
        case 2:
            return random.uniform(-10, 10)
        case 3:
            return random.choice(WORDS)
        case 4:
            return random.choice((True, False, [], {}, [[]], [{}]))
        case 5 if not finite:
            return random.choice(NOT_FINITE)
        case _:
            return random.choice(words or WORDS)


# --- tables of text ---


def of_csv(data: bytes, random: Random) -> bytes:
    """Change some cells, rows or columns of a table."""
    try:
        rows = [line.split(",") for line in data.decode().split("\n")]
    except UnicodeDecodeError:
        return of_bytes()(data, random)
    for _ in range(random.choice((1, 1, 2, 5))):
        row = rows[random.randrange(len(rows))]
        column = random.randrange(len(row))
        match random.randrange(8):
            case 0:
                row[column] = random.choice(WORDS)
            case 1:
                number = random.choice((*NUMBERS, *NOT_FINITE))
                row[column] = str(number) if abs(number) < 10**300 else "9" * 400
            case 2:
                row.insert(column, row[column])
            case 3 if len(row) > 1:
                del row[column]
            case 4:
                rows.insert(random.randrange(len(rows) + 1), list(row))
            case 5 if len(rows) > 1:
                rows.remove(row)
            case 6:
                rows[:] = [rows[0], *random.sample(rows[1:], len(rows) - 1)]
            case _:
                return of_bytes()("\n".join(map(",".join, rows)).encode(errors="replace"), random)
    return "\n".join(map(",".join, rows)).encode(errors="replace")[:MOST]


# --- arrays ---

DTYPES = ("<f8", "<f4", "<i8", "<i4", "<u8", "|b1", "<U7", "<c16", ">f8", "|S3", "<f2", "<M8[s]")
SHAPES: tuple[tuple[int, ...], ...] = ((), (0,), (1,), (0, 6), (3, 0), (1, 1, 1), (2, 3), (7, 6))
LIES = (
    *(b"(10000000000,)", b"(-1,)", b"(2147483648, 2147483648)", b"()", b"(1.5,)", b"None"),
    *(b"(10**9,)", b"(0, 99999999999999999999)", b"'x'"),
)
KINDS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)


def of_npz(data: bytes, random: Random) -> bytes:
    """Change arrays of an archive, what their headers say of them, or the archive itself."""
    if random.random() < 0.2:
        return of_bytes(b"PK\x03\x04", b"PK\x01\x02", b"\x93NUMPY", b"'descr'")(data, random)
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: np.asarray(file[name]) for name in file.files}
    except Exception:
        return of_bytes()(data, random)
    for _ in range(random.choice((1, 1, 2, 3))):
        if not arrays:
            break
        name = random.choice(list(arrays))
        match random.randrange(7):
            case 0:
                del arrays[name]
            case 1:
                arrays[random.choice((*arrays, "x", "", "../x", "a/b"))] = arrays.pop(name)
            case 2:
                arrays[name] = np.zeros(random.choice(SHAPES), random.choice(DTYPES))
            case 3:
                arrays[name] = arrays[random.choice(list(arrays))]
            case 4:
                arrays[name] = arrays[name].astype(random.choice(DTYPES[:6]), casting="unsafe") \
                    if arrays[name].dtype.kind in "fiu" else arrays[name][..., None]  # fmt: skip
            case 5:
                arrays[name] = arrays[name][: random.randrange(3)] if arrays[name].ndim else (
                    arrays[name][None])  # fmt: skip
            case _:
                _change_entry(arrays, name, random)
    return _archive(arrays, random)


def _change_entry(arrays: dict[str, Any], name: str, random: Random) -> None:
    flat = arrays[name].copy().reshape(-1)
    if flat.size and flat.dtype.kind in "fiu":
        value = random.choice((*NUMBERS, *NOT_FINITE))
        with np.errstate(all="ignore"):
            try:
                flat[random.randrange(flat.size)] = value
            except (OverflowError, ValueError):
                flat[random.randrange(flat.size)] = 1
    elif flat.size and flat.dtype.kind == "U":
        flat[random.randrange(flat.size)] = random.choice(WORDS)[: flat.dtype.itemsize // 4]
    arrays[name] = flat.reshape(arrays[name].shape)


def _archive(arrays: dict[str, Any], random: Random) -> bytes:
    out = io.BytesIO()
    with np.errstate(all="ignore"), zipfile.ZipFile(out, "w", random.choice(KINDS)) as archive:
        for name, array in arrays.items():
            entry = io.BytesIO()
            np.lib.format.write_array(entry, np.asarray(array), allow_pickle=False)
            content = entry.getvalue()
            if random.random() < 0.1:
                head, mark, rest = content.partition(b"'shape': ")
                _, close, body = rest.partition(b"), }")
                lie = random.choice(LIES)
                content = head + mark + lie + close[1:].ljust(2) + body if close else content
            elif random.random() < 0.05:
                content = of_bytes()(content, random)
            archive.writestr(f"{name}.npy", content)
    return out.getvalue()[:MOST]
