"""The scenarios that come with kinolab: one TOML file each, meshes beside them."""
