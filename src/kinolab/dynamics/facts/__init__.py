"""What planning asks of a machine besides its equations."""
