"""Caches that were damaged: bytes, lengths, places and kinds of their files."""

from __future__ import annotations

import hashlib
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path

from .storage import as_nobody
from .workshop import PLAN, Kind, Verdict, Workshop, remove

SEAL = 32  # bytes of a checksum after the first line


def _flipped(content: bytearray, rng: random.Random) -> bytes:
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return content


def _changed(content: bytearray, rng: random.Random) -> bytes:
    for _ in range(rng.randint(1, 50)):
        content[rng.randrange(len(content))] ^= rng.randrange(1, 256)
    return content


CHANGES: dict[str, Callable[[bytearray, random.Random], bytes]] = {
    "a flipped bit": _flipped,
    "bytes changed": _changed,
    "cut short": lambda content, rng: content[: rng.randrange(len(content))],
    "empty": lambda *_: b"",
    "garbage": lambda _, rng: rng.randbytes(rng.choice((1, 30, 1000, 100_000))),
    "longer": lambda content, rng: content + rng.randbytes(rng.randint(1, 1000)),
    "zeros": lambda content, _: bytes(len(content)),
    "forbidden": lambda content, _: content,
}
REPLACEMENTS: dict[str, Callable[[Path], object]] = {
    "a folder": Path.mkdir,
    "a folder with something in it": lambda path: (path / "inside").mkdir(parents=True),
    "a link to nowhere": lambda path: path.symlink_to("nowhere"),
    "a link in a ring": lambda path: path.symlink_to(path.name),
    "a pipe": os.mkfifo,
    "gone": lambda _: None,
}
DAMAGES = (*CHANGES, *REPLACEMENTS, "another's")
COMPILED = (".nbi", ".nbc")
CACHES = ("cache", "numba")


class Pristine:
    """What the caches are, so that they can be made so again."""

    def __init__(self, shop: Workshop) -> None:
        self._place, self._copies = shop.place, shop.place / "pristine"
        remove(self._copies)
        for name in CACHES:
            shutil.copytree(self._place / name, self._copies / name)
        self.files = {
            str(path.relative_to(self._copies)): _stamp(path)
            for path in self._copies.rglob("*")
            if path.is_file()
        }
        self.read = self._read_by_a_plan(shop)

    def restore(self) -> None:
        """Undo what was done to the caches."""
        for name in CACHES:
            for path in sorted((self._place / name).rglob("*"), reverse=True):
                told = str(path.relative_to(self._place))
                plain = path.is_file() and not path.is_symlink()
                if told not in self.files and (plain or not path.is_dir() or path.is_symlink()):
                    path.unlink()
                elif told in self.files and not (plain and _stamp(path) == self.files[told]):
                    remove(path)
        for told in self.files:
            path = self._place / told
            if not path.exists():
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(self._copies / told, path)

    def entries(self, compiled: bool) -> list[str]:
        """Return the entries of numba's cache that a plan reads, or the others that it reads."""
        return sorted(told for told in self.read if told.endswith(COMPILED) == compiled)

    @property
    def linked(self) -> list[str]:
        """What is linked into compiled loops, and read where they are made anew."""
        return sorted(told for told in self.files if ".linked." in told and told.endswith(COMPILED))

    def _read_by_a_plan(self, shop: Workshop) -> set[str]:
        log = shop.empty("log")

        def prepare() -> None:
            from kinolab import files

            read = files.read_ordinary

            def noted(path: Path, most: int) -> bytearray:
                with log.open("a") as file:
                    file.write(f"{path}\n")
                return read(path, most)

            files.read_ordinary = noted

        ended = shop.run(*PLAN, "--seed", "1", "--out", shop.empty("damaged"), prepare=prepare)
        if ended.code:
            raise SystemExit(ended.err)
        places = {Path(line) for line in log.read_text().split("\n") if line}
        return {
            str(path.relative_to(self._place))
            for path in places
            if path.is_relative_to(self._place) and str(path.relative_to(self._place)) in self.files
        }


_pristine: dict[Path, Pristine] = {}


def _stamp(path: Path) -> tuple[int, int, int]:
    about = path.stat()
    return about.st_size, about.st_mtime_ns, about.st_mode


def pristine(shop: Workshop) -> Pristine:
    """Return what the caches are, complete for the command that reads them."""
    if shop.place not in _pristine:
        shop.done(1)
        _pristine[shop.place] = Pristine(shop)
    return _pristine[shop.place]


def damage(path: Path, how: str, other: Path, rng: random.Random) -> None:
    """Damage a file, or put something else in its place."""
    content = path.read_bytes()
    path.unlink()
    if how in REPLACEMENTS:
        REPLACEMENTS[how](path)
    else:
        change = CHANGES.get(how, lambda *_: other.read_bytes())
        path.write_bytes(change(bytearray(content), rng))
    if how == "forbidden":
        path.chmod(0)


def _rebuilt(path: Path) -> bool:
    """Say whether an entry is whole, by its own checksum."""
    if not path.is_file():
        return False
    _, _, rest = path.read_bytes().partition(b"\n")
    return hashlib.sha256(rest[SEAL:]).digest() == rest[:SEAL]


def _strike(shop: Workshop, rng: random.Random, compiled: bool) -> Verdict:
    caches = pristine(shop)
    entries = caches.entries(compiled)
    struck = rng.sample(entries, rng.choice((1, 1, 1, 2, 3)))
    if compiled and rng.random() < 0.3:
        struck += rng.sample(caches.linked, 3)
    how = rng.choice(DAMAGES)
    verdict = Verdict(f"{how}: {', '.join(struck)}")
    folder = shop.empty("damaged")
    try:
        for told in dict.fromkeys(struck):
            path = shop.place / told
            alike = [entry for entry in entries if Path(entry).suffix == path.suffix]
            damage(path, how, caches._copies / rng.choice(alike), rng)
        prepare = None
        if how == "forbidden":
            for told in (*CACHES, *{str(Path(one).parent) for one in caches.files}):
                (shop.place / told).chmod(0o777)
            shop.place.chmod(0o777)
            prepare = as_nobody
        words = [*PLAN, "--seed", "1", "--out", folder]
        ended = shop.run(*words, prepare=prepare)
        verdict.seconds = ended.seconds
        verdict.heard(ended, [0])
        verdict.files(folder, settled=True)
        shop.compare(verdict, folder, 1)
        read = [told for told in struck if told in caches.read]
        for told in read if how != "a folder with something in it" else []:
            if not _rebuilt(shop.place / told):
                verdict.wrong.append(f"{told} is not rebuilt")
    finally:
        caches.restore()
    return verdict


def damaged_cache(shop: Workshop, rng: random.Random) -> Verdict:
    """Damage machines, meshes, grids and records that are kept."""
    return _strike(shop, rng, compiled=False)


def damaged_loops(shop: Workshop, rng: random.Random) -> Verdict:
    """Damage compiled loops that numba keeps."""
    return _strike(shop, rng, compiled=True)


def strange_cache(shop: Workshop, rng: random.Random) -> Verdict:
    """Let a cache's folder, or the locks in it, be something else."""
    caches = pristine(shop)
    name, how = (
        rng.choice(CACHES),
        rng.choice(("a file", "a link to nowhere", "a link in a ring", "locks")),
    )
    verdict = Verdict(f"the folder {name}: {how}")
    place = shop.place / name
    try:
        if how == "locks":
            for path in (shop.place / "numba").rglob("*.lock"):
                path.unlink()
                rng.choice((path.mkdir, lambda path=path: os.mkfifo(path)))()
            (shop.place / rng.choice(caches.entries(True))).unlink()
        else:
            remove(shop.place / "aside")
            place.rename(shop.place / "aside")
            if how == "a file":
                place.write_text("mine")
            else:
                place.symlink_to("nowhere" if "nowhere" in how else name)
        # Without numba's folder all is compiled, which takes minutes: a short command will do.
        words = ["check", shop.copy("damaged")] if name == "cache" or how == "locks" else ["list"]
        ended = shop.run(*words)
        verdict.seconds = ended.seconds
        verdict.heard(ended, [0])
    finally:
        if (shop.place / "aside").is_dir():
            remove(place)
            (shop.place / "aside").rename(place)
        for path in (shop.place / "numba").rglob("*.lock"):
            if not path.is_file() or path.is_symlink():
                remove(path)
        caches.restore()
    return verdict


KINDS = (
    Kind("damaged caches", 1500, damaged_cache, cold=True),
    Kind("damaged caches of compiled loops", 200, damaged_loops, cold=True),
    Kind("strange folders of caches", 60, strange_cache, cold=True),
)
