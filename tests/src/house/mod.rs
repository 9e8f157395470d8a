//! Checks of the code base itself: module order, circles of imports, size, comments, the public
//! interface of the library and paths named in the documentation.
//!
//! The binary `house` prints the results; the test `house` asserts them.

pub mod api;
pub mod circles;
pub mod comments;
pub mod graph;
pub mod inventory;
pub mod layout;
pub mod markdown;
pub mod numbers;
pub mod packages;
pub mod paths;
pub mod references;
pub mod resolve;
pub mod rooms;
pub mod signature;
pub mod sizes;
pub mod source_tree;
pub mod tokens;

/// Result of a check; the error says which file could not be read.
pub type Result<T> = std::result::Result<T, String>;
