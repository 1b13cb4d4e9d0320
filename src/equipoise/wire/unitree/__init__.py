"""Robots of Unitree that speak `unitree_hg`: topics `rt/lowstate` and `rt/lowcmd` over DDS."""
