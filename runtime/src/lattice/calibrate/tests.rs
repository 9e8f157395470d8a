//! Calibrated lattices against plates and beams in closed form.

use super::*;
