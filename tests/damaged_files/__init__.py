"""Files in which something is wrong: they are read all the same, or a message says what it is."""
