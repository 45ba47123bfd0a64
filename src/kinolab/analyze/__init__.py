"""What a machine is, why a search failed, and how a plan fares in practice."""
