//! Space-time RRT* for arms whose base moves on a known schedule
