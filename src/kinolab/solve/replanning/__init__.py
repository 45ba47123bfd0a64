"""Planning again: a motion that is known as a guess, and as what is kept while a machine moves."""
