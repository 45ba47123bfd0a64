"""Whether files are whole, judged by what their formats say and not by who wrote them."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
import tomllib
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

DRAFT = re.compile(r"\.[^/]+\.[0-9a-f]{8}(\.[a-z]+)?")  # names of files that are being written
RUN = ("scenario.toml", "README.txt", "assets/machine.json")


def drafts(folder: Path) -> list[str]:
    """Return the temporary files below a folder."""
    return sorted(str(path) for path in folder.rglob(".*") if DRAFT.fullmatch(path.name))


def broken(folder: Path) -> list[str]:
    """Return what is not whole below a folder, temporary files left out."""
    found = []
    for path in sorted(folder.rglob("*")) if folder.is_dir() else ():
        if path.is_file() and not DRAFT.fullmatch(path.name) and path.name != ".lock":
            try:
                if not _whole(path):
                    found.append(f"{path.name}: not whole")
            except Exception as error:
                found.append(f"{path.name}: {error!r}")
    return found + list(_unvouched(folder))


def _unvouched(folder: Path) -> Iterator[str]:
    """Yield what a report says that is there and is not."""
    path = folder / "report.json"
    if not path.is_file():
        return
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
        assets = dict(report["assets"])
    except (ValueError, LookupError, TypeError):
        yield "report.json: unreadable"
        return
    names = [*RUN, *(["trajectory.csv", "trajectory.npz"] if report.get("cost") else [])]
    yield from (f"{name}: missing" for name in names if not (folder / name).is_file())
    others = {path.name for path in (folder / "assets").glob("*") if path.name[0] != "."}
    yield from (f"assets/{name}: of no run" for name in others - set(assets))
    for name, digest in assets.items():
        file = folder / "assets" / name
        if not file.is_file() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
            yield f"assets/{name}: not the report's"


def _whole(path: Path) -> bool:
    content = path.read_bytes()
    return CHECKS.get(path.suffix.lower(), bool)(content)


def _csv(content: bytes) -> bool:
    rows = list(csv.reader(io.StringIO(content.decode())))
    return content.endswith(b"\n") and len({len(row) for row in rows}) == 1


def _json(content: bytes) -> bool:
    json.loads(content)
    return True


def _toml(content: bytes) -> bool:
    tomllib.loads(content.decode())
    return True


def _npz(content: bytes) -> bool:
    return zipfile.ZipFile(io.BytesIO(content)).testzip() is None


def _xml(content: bytes) -> bool:
    ElementTree.fromstring(content)
    return True


def _glb(content: bytes) -> bool:
    return content[:4] == b"glTF" and int.from_bytes(content[8:12], "little") == len(content)


def _mp4(content: bytes) -> bool:
    at, kinds = 0, set()
    while at < len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        kinds.add(content[at + 4 : at + 8])
        at += size if size >= 8 else len(content) + 1
    return at == len(content) and b"moov" in kinds


def _parquet(content: bytes) -> bool:
    return content[:4] == content[-4:] == b"PAR1"


CHECKS: dict[str, Callable[[bytes], bool]] = {
    ".csv": _csv,
    ".json": _json,
    ".toml": _toml,
    ".npz": _npz,
    ".svg": _xml,
    ".glb": _glb,
    ".mp4": _mp4,
    ".parquet": _parquet,
    ".gif": lambda content: content[:4] == b"GIF8" and content[-1:] == b"\x3b",
    ".png": lambda content: content[-8:-4] == b"IEND",
    ".html": lambda content: content.rstrip().endswith(b"</html>"),
    ".txt": lambda content: content.endswith(b"\n"),
    ".jsonl": lambda content: content == b"" or content.endswith(b"\n"),
}
