//! Exploration and inspection frontiers of voxel maps, clustered and kept up to date incrementally
