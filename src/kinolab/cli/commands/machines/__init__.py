"""Commands about machines: what they are, whether they are well made, how they move."""
