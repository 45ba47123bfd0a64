"""What pushes the joints of a robot, and what resists them."""
