"""Disks that are full, folders that cannot be written, and processes that may open little."""

from __future__ import annotations

import ctypes
import os
import random
import resource
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .kills import COMMANDS, place_for, words_of
from .whole_files import broken
from .workshop import PLAN, Kind, Verdict, Workshop, remove

NOBODY = 65534  # a user without rights
REFUSED = (0, 2, 6)  # exit codes: it went well, the folder is refused, out of resources
CLONE_NEWNS = 0x00020000


@contextmanager
def mounted(place: Path, *options: str) -> Iterator[None]:
    """Mount a file system in memory."""
    place.mkdir(parents=True, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", *options, "tmpfs", str(place)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)
        shutil.rmtree(place, ignore_errors=True)


def full_disk(shop: Workshop, rng: random.Random) -> Verdict:
    """Let a command write to a disk that has too little room."""
    kilobytes = rng.choice((0, 4, 8, 16, 32, 64, 96, 128, 160, 200, 240, 280, 400))
    inodes = rng.choice((0, 0, 0, rng.randint(3, 12)))
    names = ("plan", "plan, improved", "plan check", "plan plot", "plan execute", "plan view")
    name = rng.choices(names, (6, 2, 1, 1, 1, 1))[0]
    inodes = 0 if COMMANDS[name][1] else inodes  # or there is no room for the run itself
    verdict = Verdict(f"{kilobytes} kB and {inodes or 'any'} files left for {name}")
    disk = shop.place / "disk"
    with mounted(disk, "-o", "size=4m" + (f",nr_inodes={inodes}" if inodes else "")):
        folder = disk / "run"
        if COMMANDS[name][1] or (inodes == 0 and rng.random() < 0.4):
            with suppress(OSError, shutil.Error):
                shutil.copytree(shop.done(1), folder)
        _fill(disk / "other", kilobytes)
        before = _files(folder)
        ended = shop.run(*words_of(name, folder))
        verdict.seconds = ended.seconds
        verdict.heard(ended, REFUSED)
        _said(verdict, ended.code, ended.err)
        verdict.files(folder, settled=True)
        if ended.code and COMMANDS[name][1] and before - _files(folder):
            verdict.wrong.append(f"files are gone: {before - _files(folder)}")
        (disk / "other").unlink(missing_ok=True)
        subprocess.run(["mount", "-o", "remount,size=16m,nr_inodes=1000", disk], check=True)
        if name == "plan":
            verdict.heard(shop.run(*words_of(name, folder)), [0])
            verdict.files(folder, settled=True)
            shop.compare(verdict, folder, 1)
    return verdict


def _fill(path: Path, left: int) -> None:
    """Fill a disk but for some kilobytes."""
    with suppress(OSError):
        room = os.statvfs(path.parent)
        size = room.f_bavail * room.f_frsize - 1024 * left
        with path.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, max(size, 1))


def _files(folder: Path) -> set[str]:
    return {str(path) for path in folder.rglob("*") if path.is_file()}


def _said(verdict: Verdict, code: int | None, err: str) -> None:
    if code and "rror: " not in err:
        verdict.wrong.append(f"exit code {code} without a word: {err[-300:]}")


def full_cache(shop: Workshop, rng: random.Random) -> Verdict:
    """Let a command keep nothing: the caches' disk, or that of temporary files, is full."""
    variable = rng.choice(("KINOLAB_CACHE", "TMPDIR"))
    verdict = Verdict(f"no room in {variable}")
    disk, folder = shop.place / "disk", shop.empty("run")
    with mounted(disk, "-o", "size=64k"):
        _fill(disk / "other", rng.choice((0, 4, 8)))
        words = [*PLAN, "--set", "system.parameters.R=0.2", "--seed", "1", "--out", folder]
        ended = shop.run(*words, environment={variable: str(disk)})
        verdict.seconds = ended.seconds
        verdict.heard(ended, [0])
        verdict.partial += broken(disk) if not (disk / "other").exists() else []
    verdict.files(folder, settled=True)
    return verdict


def small_files(shop: Workshop, rng: random.Random) -> Verdict:
    """Limit how large a file may become, as quotas do."""
    most = int(1024 * 2 ** rng.uniform(0.0, 8.0))
    name = rng.choice(
        ("plan", "plan", "plan, improved", "plan with pictures", "plan execute", "plan plot")
    )
    verdict = Verdict(f"files of {most} bytes at most for {name}")
    folder = place_for(shop, name, "small")
    before = _files(folder)

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    ended = shop.run(*words_of(name, folder), prepare=prepare)
    verdict.seconds = ended.seconds
    verdict.heard(ended, REFUSED)
    _said(verdict, ended.code, ended.err)
    verdict.files(folder, settled=True)
    if COMMANDS[name][1] and before - _files(folder):
        verdict.wrong.append(f"files are gone: {before - _files(folder)}")
    return verdict


# --- folders that are not as they should be ---


def as_nobody() -> None:
    """Give up all rights."""
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)


def _read_only(folder: Path) -> Callable[[], None]:
    """Return what makes a folder read-only for one process and those that it starts."""

    def prepare() -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.unshare(CLONE_NEWNS):
            raise OSError(ctypes.get_errno(), "unshare")
        folder.mkdir(parents=True, exist_ok=True)
        place = str(folder)
        for words in (
            ["--make-rprivate", "/"],
            ["--bind", place, place],
            ["-o", "remount,ro,bind", place],
        ):
            subprocess.run(["mount", *words], check=True)
        os.chdir(os.getcwd())

    return prepare


def _vanish(folder: Path, after: float) -> threading.Thread:
    """Remove a folder again and again while a command works in it."""

    def work() -> None:
        until = time.monotonic() + after
        while time.monotonic() < until:
            shutil.rmtree(folder, ignore_errors=True)
            time.sleep(0.003)

    thread = threading.Thread(target=work)
    thread.start()
    return thread


PLACES = (
    "read-only", "nobody's", "a file", "below a file", "a link", "a link to nowhere",
    "a link in a ring", "/dev/null", "/dev/full", "/proc", "assets is a file",
    "report.json is a folder",
    "trajectory.csv is a folder", "scenario.toml is a link to nowhere", "plots is a file",
    "bytes that are no text", "a long name", "a name too long", "removed",
    "removed again and again",
    "the working folder is removed", "a foreign scenario.toml", "report.json is a pipe",
    "a newline", "a run that nobody may read", "empty",
)  # fmt: skip


def gone(folder: Path, what: str) -> bool:
    """Whether a file that a report names is not there at all."""
    name, _, lack = what.partition(": ")
    return lack in ("missing", "not the report's") and not (folder / name).exists()


def strange_place(shop: Workshop, rng: random.Random) -> Verdict:  # noqa: PLR0912, PLR0915
    """Let a command work in a folder that is not as it should be."""
    place = rng.choice(PLACES)
    name = rng.choices(
        ("plan", "plan, improved", "plan check", "plan plot", "plan execute", "plan view"),
        (5, 2, 2, 1, 1, 1),
    )[0]
    verdict = Verdict(f"{name} where the folder is: {place}")
    folder: Path | bytes = (
        place_for(shop, name, "strange") if rng.random() < 0.5 else shop.copy("strange")
    )
    spot = shop.place / "strange"
    remove(shop.place / "elsewhere")
    prepare: Callable[[], None] | None = None
    thread: threading.Thread | None = None
    codes: tuple[int, ...] = (0, 2)
    if place == "read-only":
        prepare = _read_only(spot)
    elif place in ("nobody's", "a run that nobody may read"):
        spot.mkdir(exist_ok=True)
        spot.chmod(0o755 if place == "nobody's" else 0o700)
        prepare = as_nobody
    elif place == "a file":
        remove(spot)
        spot.write_text("mine\n")
    elif place == "below a file":
        remove(spot)
        spot.write_text("mine\n")
        folder = spot / "run"
    elif place.startswith("a link"):
        if spot.is_dir():
            spot.rename(shop.place / "elsewhere")
        elif place == "a link":
            (shop.place / "elsewhere").mkdir()
        remove(spot)
        targets = {
            "a link": "elsewhere",
            "a link to nowhere": "nowhere",
            "a link in a ring": "strange",
        }
        remove(shop.place / "nowhere")
        spot.symlink_to(targets[place])
    elif place.startswith("/"):
        folder = Path(place)
    elif " is a " in place:
        spot.mkdir(exist_ok=True)
        file, _, what = place.partition(" is a ")
        remove(spot / file)
        if what == "file":
            (spot / file).write_text("mine\n")
        elif what == "folder":
            (spot / file / "inside").mkdir(parents=True)
        elif what == "pipe":
            os.mkfifo(spot / file)
        else:
            (spot / file).symlink_to("nowhere")
    elif place == "bytes that are no text":
        folder = os.fsencode(shop.place) + b"/strange-\xff\xfe"
        shutil.rmtree(folder, ignore_errors=True)
        if spot.is_dir():
            spot.rename(os.fsdecode(folder))
    elif place in ("a long name", "a name too long", "a newline"):
        long = {
            "a long name": "n" * 250,
            "a name too long": "n" * 300,
            "a newline": "a\nb\r\x1b[31m",
        }
        folder = shop.place / long[place]
        with suppress(OSError):
            remove(folder)
            if spot.is_dir():
                spot.rename(folder)
    elif place == "removed":
        remove(spot)
    elif place == "removed again and again":
        thread = _vanish(spot, rng.uniform(0.02, 0.4))
    elif place == "the working folder is removed":
        gone = shop.place / "gone"

        def prepare() -> None:
            gone.mkdir(exist_ok=True)
            os.chdir(gone)
            gone.rmdir()

        if rng.random() < 0.5 and not COMMANDS[name][1]:
            folder = Path("runs")
    elif place == "a foreign scenario.toml":
        remove(spot)
        spot.mkdir()
        (spot / "scenario.toml").write_text("mine\n")
    elif place == "empty":
        remove(spot)
        spot.mkdir()
    mine = spot.read_text() if spot.is_file() else ""
    ended = shop.run(*words_of(name, folder), prepare=prepare)  # type: ignore[arg-type]
    if thread:
        thread.join()
    verdict.seconds = ended.seconds
    verdict.heard(ended, codes)
    _said(verdict, ended.code, ended.err)
    if mine and spot.read_text() != mine:
        verdict.wrong.append("a file was replaced")
    if place == "a foreign scenario.toml" and (spot / "scenario.toml").read_text() != "mine\n":
        verdict.wrong.append("somebody's scenario was replaced")
    where = Path(os.fsdecode(folder))
    for link in [*where.glob("report.json"), *where.glob("assets")] if "is a" in place else ():
        if link.is_fifo() or link.is_file():
            link.unlink()
    strange = "/proc" in str(where) or " is a " in place or "foreign" in place
    if os.path.isdir(where) and not strange:
        verdict.files(where, settled=True)
        if thread:  # which removed some of them, perhaps after the command had ended
            verdict.partial = [what for what in verdict.partial if not gone(where, what)]
    if spot.exists():
        spot.chmod(0o755)
    if where != spot and where.parent == shop.place:
        with suppress(OSError):
            remove(where)
    return verdict


def few_handles(shop: Workshop, rng: random.Random) -> Verdict:
    """Let a command open few files, start few processes, or take little memory."""
    what = rng.choice(("files", "files", "processes", "memory"))
    name = rng.choice(("plan", "plan, improved", "plan with pictures", "plan --jobs 2, threads",
                       "plan --jobs 2, processes", "plan check", "plan execute"))  # fmt: skip
    most = {
        "files": rng.randint(6, 40),
        "processes": rng.randint(0, 4),
        "memory": rng.randint(300, 1500),
    }[what]
    verdict = Verdict(f"{most} {what} at most for {name}")
    folder = place_for(shop, name, "few")

    def prepare() -> None:
        if what == "files":
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
        elif what == "memory":
            resource.setrlimit(resource.RLIMIT_AS, (most * 2**20, most * 2**20))
        else:  # root has no such limit
            resource.setrlimit(resource.RLIMIT_NPROC, (most, most))
            as_nobody()

    if what == "processes":
        for path in (shop.place, *([folder] if folder.is_dir() else [])):
            path.chmod(0o777)
        for path in folder.rglob("*"):
            path.chmod(0o777 if path.is_dir() else 0o666)
    ended = shop.run(*words_of(name, folder), prepare=prepare)
    verdict.seconds = ended.seconds
    verdict.heard(ended, (0, 2, 3, 6))
    _said(verdict, ended.code, ended.err)
    verdict.files(folder, settled=True)
    if ended.code == 0 and name == "plan":
        shop.compare(verdict, folder, 1)
    return verdict


KINDS = (
    Kind("full disk", 500, full_disk),
    Kind("full disk of caches", 100, full_cache),
    Kind("files of limited size", 300, small_files),
    Kind("strange folders", 1500, strange_place),
    Kind("few files, processes, memory", 400, few_handles),
)
