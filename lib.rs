//! umbragraph
