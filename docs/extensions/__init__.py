"""What the site has of its own: pages made of the code, formulas without a network, a check of its links."""
