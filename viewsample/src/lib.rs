//! Viewpoint generation and scoring for sensing robots: state libraries, visibility, information gain
