"""Safety reports: what was assumed, simulated and found, as one page that can be handed on."""
