"""False plans for the verifier to refuse, and good ones to accept, judged by others."""
