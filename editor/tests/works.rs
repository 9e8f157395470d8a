//! Whole workflows: a study from the first sheet to the table, creases, cuts and heat by hand,
//! exports, files opened, saved and added.

mod works {
    pub mod common;
    mod dialogs;
    mod export;
    mod files;
    mod gap;
    mod paint;
    mod stages;
    mod study;
    mod templates;
}
