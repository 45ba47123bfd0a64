"""What stands in the way: obstacles, floors, and the world of both."""
