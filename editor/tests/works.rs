//! Whole pieces of work: a study from the first sheet to the table, a sheet that is folded, cut and warmed by hand, a run that is exported, files that
//! are opened, saved and added.

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
