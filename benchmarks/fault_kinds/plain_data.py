"""Plain data and bytes that are broken at random: the grammar of hostile files."""

from __future__ import annotations

import json
import math
import random
from typing import Any

NUMBERS = (
    0, 1, -1, 0.5, -0.0, 1e-300, 1e300, 1e308, -1e308, 1e-9, 1e9, 2**31, 2**63, 2**70, -(2**63),
    10**400, math.nan, math.inf, -math.inf,
)  # fmt: skip
TEXTS = (
    "", " ", "x", "x" * 10_000, "\0", "a\nb", "../../etc/passwd", "/dev/zero", "/dev/full", "/",
    ".", "\u202e", "\ufeff", "é" * 300, "{}", "%s%n", "__import__('os')", "1/0", "pi/0", "9**9**9",
    "nan", "1e999", "-", "inf deg", "a.b.c", "[x]", "machine.py:f", ":", "a:b:c",
    "http://example.org/x.stl",
)  # fmt: skip


def any_value(rng: random.Random, depth: int = 0) -> Any:
    """Return any value."""
    kind = rng.randrange(7)
    if kind == 0:
        return rng.choice(TEXTS)
    if kind in (1, 2):
        return rng.choice(NUMBERS)
    if kind == 3:
        return rng.random() < 0.5
    if kind == 4 and depth < 3:
        return [any_value(rng, depth + 1) for _ in range(rng.randint(0, 4))]
    if kind == 5 and depth < 3:
        return {
            rng.choice(("x", "y", "name", "file", "box", "")): any_value(rng, depth + 1)
            for _ in range(3)
        }
    if kind == 6:
        deep: Any = []
        for _ in range(rng.choice((3, 30, 90))):
            deep = [deep]
        return deep
    return rng.uniform(-100, 100)


def _nodes(tree: Any) -> list[tuple[Any, Any]]:
    """Return all (container, key) of plain data."""
    found = []
    if isinstance(tree, dict | list):
        for key in tree if isinstance(tree, dict) else range(len(tree)):
            found += [(tree, key), *_nodes(tree[key])]
    return found


def mutate(tree: Any, rng: random.Random) -> Any:
    """Break plain data in one to three places."""
    tree = json.loads(json.dumps(tree))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        nodes = _nodes(tree)
        if not nodes:
            return any_value(rng)
        holder, key = rng.choice(nodes)
        how = rng.randrange(8)
        if how == 0:
            del holder[key]
        elif how == 1 and isinstance(holder, dict):
            holder[rng.choice((key + "x", key.upper(), key[:-1], *TEXTS))] = holder.pop(key)
        elif how == 2 and isinstance(holder, list):
            holder.insert(key, holder[key])
        elif how == 3:
            other, place = rng.choice(nodes)
            if (isinstance(other, dict) and place in other) or (
                isinstance(other, list) and place < len(other)
            ):
                holder[key] = json.loads(json.dumps(other[place]))
        elif (
            how == 4 and isinstance(holder[key], int | float) and not isinstance(holder[key], bool)
        ):
            holder[key] = rng.choice(
                (-holder[key], holder[key] * 1e6, holder[key] * 1e-6, *NUMBERS)
            )
        elif how == 5 and isinstance(holder, dict):
            holder[rng.choice(("x", "unknown", *TEXTS))] = any_value(rng)
        elif how == 6 and isinstance(holder[key], str):
            holder[key] = rng.choice(TEXTS)
        else:
            holder[key] = any_value(rng)
    return tree


def spoil(content: bytes, rng: random.Random) -> bytes:
    """Break bytes: flip, cut, insert, repeat, swap lines, or change the encoding."""
    how = rng.randrange(10)
    broken = bytearray(content)
    if not broken:
        return rng.randbytes(20)
    at, length = rng.randrange(len(broken)), rng.choice((1, 4, 50, 1000))
    if how == 0:
        for _ in range(rng.randint(1, 20)):
            broken[rng.randrange(len(broken))] = rng.randrange(256)
    elif how == 1:
        del broken[at:]
    elif how == 2:
        del broken[at : at + length]
    elif how == 3:
        broken[at:at] = rng.randbytes(length)
    elif how == 4:
        broken[at:at] = broken[at : at + length] * rng.choice((1, 3, 100))
    elif how == 5:
        lines = content.split(b"\n")
        rng.shuffle(lines)
        return b"\n".join(lines)
    elif how == 6:
        return rng.choice(
            (
                b"",
                b"\n",
                b"\0" * 100,
                rng.randbytes(500),
                b"{" * 5000,
                b"[" * 100_000,
                b"\xef\xbb\xbf" + content,
            )
        )
    elif how == 7:
        return content.decode("latin-1").encode(rng.choice(("utf-16", "utf-32", "utf-8")))
    elif how == 8:
        numbers = [
            b"nan",
            b"1e999",
            b"-1",
            b"99999999999999999999",
            b"0x10",
            b"1_0",
            b"",
            b"1,1",
            b"true",
        ]
        words = content.split(b" ") if b" " in content else content.split(b",")
        words[rng.randrange(len(words))] = rng.choice(numbers)
        return (b" " if b" " in content else b",").join(words)
    else:
        broken[at] ^= 1 << rng.randrange(8)
    return bytes(broken)


def toml(tree: dict[str, Any]) -> str:
    """Write plain data as TOML, with tables in one line each."""
    return "\n".join(f"{_key(key)} = {inline(value)}" for key, value in tree.items()) + "\n"


def _key(key: str) -> str:
    return json.dumps(key)


def inline(value: Any) -> str:
    """Write a value as TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)} = {inline(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)
