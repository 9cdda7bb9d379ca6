//! Log-odds voxel maps for robots: sensor integration, ray casts, distance fields, cost maps and regions
