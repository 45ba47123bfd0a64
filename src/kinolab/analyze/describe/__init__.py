"""``plan describe``: structure and controllability of a machine."""
