"""A scene: what is seen, its meshes and its motion, whoever draws it: film, page, GLB, viewers."""
