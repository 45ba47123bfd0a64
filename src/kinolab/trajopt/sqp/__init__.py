"""Sequential quadratic programming within trust regions."""
