"""Time means, formed in place while the run goes on."""
