"""What is done again and again, each in an environment of its own: ``nox -l`` lists it.

The commands are those of README, CONTRIBUTING and `.ci/run`.
"""

from pathlib import Path

import nox

VERSIONS = nox.project.python_versions(nox.project.load_toml("pyproject.toml"))

nox.options.sessions = ["lint", "test"]


@nox.session(python=VERSIONS)
def test(session: nox.Session) -> None:
    """Run the quick tests."""
    session.install(".[test]")
    session.run("pytest", *session.posargs)


@nox.session(name="test-all")
def test_all(session: nox.Session) -> None:
    """Run all tests but the long ones."""
    session.install(".[test-all]")
    session.run("pytest", "-m", "not long", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Format, lint, check types and the direction of imports."""
    session.install("-e", ".[dev]")
    session.run("ruff", "format", "--check", ".")
    session.run("ruff", "check", ".")
    session.run("mypy")
    session.run("lint-imports")


@nox.session
def docs(session: nox.Session) -> None:
    """Build the documentation site."""
    session.install(".[docs]")
    session.run("python", "-m", "sphinx", "-W", "-q", "-b", "html", "docs", "site")


@nox.session(name="warm-up")
def warm_up(session: nox.Session) -> None:
    """Compile all inner loops."""
    session.install(".")
    session.run("plan", "warm-up")


@nox.session
def lock(session: nox.Session) -> None:
    """Write the lock of versions and hashes anew."""
    session.install("uv")
    session.run(
        *("uv", "pip", "compile", "--universal", "--generate-hashes", "--no-emit-index-url"),
        *("--no-emit-find-links", "--extra", "dev", "--python-version", "3.11"),
        *("--custom-compile-command", "nox -s lock"),
        *("pyproject.toml", "--output-file", "requirements.lock", *session.posargs),
    )


@nox.session(python=VERSIONS)
def release(session: nox.Session) -> None:
    """Build wheel and source archive, and try the wheel without the source beside it."""
    session.install("build")
    session.run("python", "-m", "build")
    wheels = sorted(Path("dist").resolve().glob("*.whl"), key=lambda wheel: wheel.stat().st_mtime)
    session.install(f"{wheels[-1]}[bench,course,robots]")
    session.run("python", str(Path("tools/try_release.py").resolve()), session.create_tmp())
