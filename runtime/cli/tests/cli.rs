//! Contract of the command line: flags, JSON keys, exit statuses and messages of the built program.

mod cli {
    pub mod common;
    mod faults;
    mod generate;
    mod link;
    mod measure;
    mod mutants;
    mod run;
    mod study;
    mod trust;
}
