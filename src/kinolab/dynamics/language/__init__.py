"""The words in which a machine is written down."""
