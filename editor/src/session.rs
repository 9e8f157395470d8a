//! Session: an edited scene and its world, with play, pause, step and rollback. No window, no
//! graphics.
//!
//! `state` is the session itself; `clock` advances time, `edit` changes the scene and updates the
//! world, `past` goes back in time, `hands` grabs and pins, `move_item` moves bodies and heaters,
//! `paint` creases, cuts and heats, `file` opens and saves, `compare` runs variants at the same
//! time, `recording` plays a recording in place of a simulation, `host` serves the live link.

mod clock;
mod compare;
mod edit;
mod file;
mod hands;
mod host;
mod item;
mod message;
mod move_item;
mod paint;
mod parameter_access;
mod past;
mod recording;
mod state;
mod timing;
mod variant;

pub(crate) use clock::ROUNDING;
pub use clock::{FRAME_BUDGET, HISTORY, SPEEDS};
pub use compare::MAX_VARIANTS;
pub use hands::Hand;
pub use item::Item;
pub use message::Message;
pub use state::Session;
pub use timing::Timing;
pub use variant::Variant;
