"""What states are made of besides plain numbers."""
