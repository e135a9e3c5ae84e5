"""Values and things that all rooms speak of: scenarios, rules, the clock, bodies, events."""
