"""What tools/scaling-model is made of: decomposition, halo traffic, costs, the replay of a step, tables and figures."""
