"""A software rasteriser: triangles to pixels."""
