"""What parts of a machine lack, do twice, or do elsewhere than others of their kind."""
