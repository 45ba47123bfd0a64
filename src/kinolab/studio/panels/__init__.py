"""The panels of the studio: a tab of the page each."""
