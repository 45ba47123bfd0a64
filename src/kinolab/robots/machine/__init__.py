"""From a tree of links to a machine."""
