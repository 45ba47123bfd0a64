"""SceneColors up a film: the backdrop, the camera, the inset; all that is done before drawing."""
