"""A person: a mind in a body that walks."""
