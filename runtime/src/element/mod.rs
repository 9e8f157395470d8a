//! What pulls on masses: each element's energy and force, alone. Elements know masses by index and nothing of engines.

pub mod flexion_limit;
pub mod spring;
pub mod thickness_limit;
