"""The reasoning cycle of an agent: beliefs, plans, intentions, and what moves them on."""
