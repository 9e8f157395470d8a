//! A session: one scene being edited and one world of it, played, paused, stepped, gone back in. No window, no graphics.
//!
//! `clock` lets time pass, `edit` changes the scene and brings the world after it, `past` goes back in time, `hands` pulls and pins, `carry` puts bodies and
//! heaters elsewhere, `paint` folds, cuts and warms, `file` opens and saves, `compare` has variants in step with it, `message` is what the user should know,
//! `recording` shows a recording in place of a simulation.

mod carry;
mod clock;
mod compare;
mod edit;
mod file;
mod hands;
mod host;
mod item;
mod knobs;
mod message;
mod paint;
mod past;
mod recording;
mod state;
mod timing;
mod variant;

pub(crate) use clock::ROUNDING;
pub use clock::{FRAME_BUDGET, HISTORY, SPEEDS};
pub use compare::MOST_BESIDE;
pub use hands::Hand;
pub use item::Item;
pub use message::Message;
pub use state::Session;
pub use timing::Timing;
pub use variant::Variant;
