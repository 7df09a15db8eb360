"""What tools/plot-sandbox is made of: reading a run, strain, bands, surface and forces, figures."""
