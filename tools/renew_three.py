"""Write anew the part of three.js that ``scene.html`` carries: ``python tools/renew_three.py``.

The npm client fetches both packages into a folder that is thrown away. The pinned versions decide
every byte that comes out: to renew, change them here, run this, and look at the page's tests.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

THREE, ESBUILD = "0.187.0", "0.28.2"
HOME = Path(__file__).resolve().parents[1] / "src" / "kinolab" / "show" / "page"

# What the page's own modules use; the bundler leaves out everything else.
CORE = """
BufferAttribute BufferGeometry CircleGeometry Color DepthTexture DirectionalLight DoubleSide
Float32BufferAttribute FrontSide GreaterDepth Group HemisphereLight LineBasicMaterial LineSegments
Mesh MeshBasicMaterial MeshLambertMaterial OrthographicCamera PCFShadowMap PerspectiveCamera Plane
PlaneGeometry RingGeometry SRGBColorSpace Scene ShaderMaterial SphereGeometry Vector3
WebGLRenderTarget WebGLRenderer
"""
LINES = ("LineMaterial", "LineSegments2", "LineSegmentsGeometry")  # lines wider than a pixel


def entry() -> str:
    """Return the module whose exports are the bundle's."""
    lines = [f'export {{ {name} }} from "three/examples/jsm/lines/{name}.js";' for name in LINES]
    return "\n".join([f'export {{ {", ".join(CORE.split())} }} from "three";', *lines, ""])


def main() -> None:
    """Fetch, bundle and write ``three.min.js`` and its licence."""
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "package.json").write_text('{"private": true}')
        packages = [f"three@{THREE}", f"esbuild@{ESBUILD}"]
        subprocess.run(["npm", "install", "--silent", *packages], cwd=folder, check=True)
        (folder / "entry.mjs").write_text(entry())
        bundle = ["--bundle", "--minify", "--format=iife", "--global-name=THREE", "--target=es2021"]
        banner = f"--banner:js=/* three.js {THREE}, MIT licence, https://threejs.org */"
        out = f"--outfile={HOME / 'three.min.js'}"
        esbuild = folder / "node_modules" / ".bin" / "esbuild"
        comments = "--legal-comments=none"
        subprocess.run(
            [esbuild, "entry.mjs", *bundle, banner, comments, out], cwd=folder, check=True
        )
        licence = (folder / "node_modules" / "three" / "LICENSE").read_bytes()
        (HOME / "three.LICENSE").write_bytes(licence)


if __name__ == "__main__":
    main()
