//! Hybrid A* for bases that drive, reverse and turn in place; grid distances; trapezoid timing
