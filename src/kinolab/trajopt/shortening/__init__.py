"""Motions made shorter: detours and cycles left out, all that stays made quicker."""
