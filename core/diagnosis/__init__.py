"""What a point set says of itself: noise, density, gaps, and whether it is fit for reconstruction (§1)."""
