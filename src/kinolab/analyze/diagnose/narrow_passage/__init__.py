"""By how much is a passage too narrow? Geometry only, without dynamics."""
