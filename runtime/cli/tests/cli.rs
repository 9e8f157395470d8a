//! Contract of the command line: flags, JSON keys, exit statuses and messages of the built program.

mod cli {
    pub mod common;
    mod damaged_files;
    mod generate;
    mod invalid_input;
    mod link;
    mod measure;
    mod run;
    mod snapshots_and_fuzzing;
    mod study;
}
