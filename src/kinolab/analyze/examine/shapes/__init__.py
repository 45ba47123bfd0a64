"""What of a machine its shapes and places tell: what touches, carries, rolls and steers."""
